// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/plain_file.h"

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRemedy =
    "give another path, or leave the output out if --help calls it optional";

}  // namespace

std::string WhyNotPlain(const fs::path& path) {
  std::error_code ignored;
  switch (fs::status(path, ignored).type()) {
    case fs::file_type::directory:
      return "is a folder";
    case fs::file_type::fifo:
      return "is a FIFO";
    case fs::file_type::socket:
      return "is a socket";
    case fs::file_type::character:
    case fs::file_type::block:
      return "is a device";
    default:
      return {};
  }
}

void RequirePlain(const fs::path& path) {
  const std::string why = WhyNotPlain(path);
  if (!why.empty()) throw DataError("{}: {}, a file is needed", path.string(), why);
}

void RequirePlaceForFile(const fs::path& path, const std::string& role) {
  const fs::path name = path.filename();
  const bool is_folder_name = name.empty() || name == "." || name == "..";
  const std::string why = is_folder_name ? "is a folder" : WhyNotPlain(path);
  if (!why.empty()) throw UsageError("{}: {}; {}", role, why, kRemedy);
  std::error_code ignored;
  for (fs::path folder = fs::absolute(path).parent_path();; folder = folder.parent_path()) {
    const fs::file_status status = fs::status(folder, ignored);
    if (!fs::exists(status) && folder.has_relative_path()) continue;
    if (fs::is_directory(status)) return;
    throw UsageError("{}: {} is no folder; {}", role, folder.string(), kRemedy);
  }
}

}  // namespace nightmap
