// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/files.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <system_error>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "pipeline/base/error.h"
#include "pipeline/base/plain_file.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

std::string Reason() { return std::strerror(errno); }

}  // namespace

std::string ReadFile(const fs::path& path) {
  RequirePlain(path);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw DataError("{}: cannot read: {}", path.string(), Reason());
  std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (stream.bad()) throw DataError("{}: cannot read: {}", path.string(), Reason());
  return bytes;
}

std::string HashBytes(std::string_view bytes) {
  return fmt::format("{:016x}", XXH3_64bits(bytes.data(), bytes.size()));
}

std::string HashFile(const fs::path& path, std::int64_t begin) {
  RequirePlain(path);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             &std::fclose);
  if (!file || std::fseek(file.get(), begin, SEEK_SET) != 0) {
    throw DataError("{}: cannot read: {}", path.string(), Reason());
  }
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(),
                                                                              &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  std::vector<char> buffer(1 << 20);
  while (const std::size_t size = std::fread(buffer.data(), 1, buffer.size(), file.get())) {
    XXH3_64bits_update(state.get(), buffer.data(), size);
  }
  if (std::ferror(file.get())) throw DataError("{}: cannot read: {}", path.string(), Reason());
  return fmt::format("{:016x}", XXH3_64bits_digest(state.get()));
}

void WriteFile(const fs::path& path, std::string_view bytes) {
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  if (!stream) throw DataError("{}: cannot write: {}", path.string(), Reason());
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.flush();
  if (!stream) {
    throw DataError(
        "{}: cannot write: {}; free space on that disk and run again", path.string(), Reason());
  }
}

}  // namespace nightmap
