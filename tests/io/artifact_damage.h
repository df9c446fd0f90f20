// SPDX-License-Identifier: Apache-2.0
// Damage of a valid artifact as a fuzzer makes it: whatever the bytes are, a reader returns or
// throws an Error that names the file. It neither crashes nor takes much more memory than the file.
#pragma once

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <new>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/memory.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap {

// One number written as text, or a run of bytes, becomes another: sizes and indices are what
// readers trust.
inline void ReplaceNumber(Random& random, std::string* bytes) {
  static const std::array<std::string, 12> kNumbers = {"-1",
                                                       "0",
                                                       "1e300",
                                                       "nan",
                                                       "inf",
                                                       "4294967296",
                                                       "99999999999999999999",
                                                       "-2147483648",
                                                       "2147483647",
                                                       "",
                                                       "[[[[[[[[",
                                                       "\"x\""};
  std::size_t begin = random.Index(bytes->size());
  while (begin < bytes->size() && std::isdigit(static_cast<unsigned char>((*bytes)[begin])) == 0) {
    ++begin;
  }
  std::size_t end = begin;
  while (end < bytes->size() && std::isdigit(static_cast<unsigned char>((*bytes)[end])) != 0) ++end;
  bytes->replace(begin, end - begin, kNumbers[random.Index(kNumbers.size())]);
}

inline void ReplaceInteger(Random& random, std::string* bytes) {
  static constexpr std::array<std::int64_t, 8> kIntegers = {
      0, -1, 1, 255, 0x7fffffff, -0x80000000LL, 1'000'000'000'000, INT64_MAX};
  const std::size_t size = random.Index(2) == 0 ? 4 : 8;
  if (bytes->size() < size) return;
  const std::size_t at = random.Index(bytes->size() / size) * size;
  std::memcpy(bytes->data() + at, &kIntegers[random.Index(kIntegers.size())], size);
}

inline std::string Damaged(std::string bytes, std::uint64_t seed) {
  Random random(1, seed);
  for (std::size_t i = 0; i <= seed % 3 && !bytes.empty(); ++i) {
    const std::size_t at = random.Index(bytes.size());
    switch (random.Index(6)) {
      case 0:
        bytes.resize(at);
        break;
      case 1:
        bytes[at] = static_cast<char>(random.Index(256));
        break;
      case 2:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.Index(8)));
        break;
      case 3:
        bytes.insert(at, bytes.substr(random.Index(bytes.size()), random.Index(40)));
        break;
      case 4:
        ReplaceNumber(random, &bytes);
        break;
      default:
        ReplaceInteger(random, &bytes);
    }
  }
  return bytes;
}

// Bytes of address space that the process had when it first asked.
inline rlim_t BytesAtStart() {
  static const rlim_t bytes = [] {
    std::size_t num_pages = 0;
    std::ifstream("/proc/self/statm") >> num_pages;
    return num_pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
  }();
  return bytes;
}

// Lets the process take that much more memory than at its start, and ends it where it wants more,
// even where an allocation's failure is caught.
inline void LimitMemory([[maybe_unused]] rlim_t more_bytes) {
#ifndef __SANITIZE_ADDRESS__  // which reserves all addresses
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = BytesAtStart() + more_bytes;
  setrlimit(RLIMIT_AS, &limit);
#endif
  std::set_new_handler([] { _exit(3); });
}

// Where a library was refused what a damaged size asks of it, a reader can tell damage from lack of
// memory only if there is some left: MemoryWatch.
inline void ReadWithLittleMemory(const std::function<void(const std::filesystem::path&)>& read,
                                 const std::filesystem::path& path) {
  constexpr rlim_t kLittle_bytes = 128 << 20;  // OpenImageIO takes 64 MiB for any picture
  constexpr rlim_t kSome_bytes = 1 << 30;
  LimitMemory(kLittle_bytes);
  try {
    read(path);
  } catch (const OutOfMemory&) {
    LimitMemory(kSome_bytes);
    read(path);
  }
}

// Reads `num_damaged` damaged copies of the file in a process of their own. `name` is what they are
// called; `read` takes a path.
inline void ExpectDamageIsSurvived(const TemporaryFolder& folder,
                                   const std::filesystem::path& valid,
                                   const std::function<void(const std::filesystem::path&)>& read,
                                   std::uint64_t num_damaged = 400) {
  const std::string bytes = ReadBytes(valid);
  ASSERT_NO_THROW(read(valid));
  const auto path = folder / ("damaged" + valid.extension().string());
  // Progress of the other process.
  void* shared = mmap(
      nullptr, sizeof(std::uint64_t), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  auto* seed = new (shared) std::atomic<std::uint64_t>(0);
  const pid_t child = fork();
  if (child == 0) {
    for (; *seed < num_damaged; ++*seed) {
      folder.Write(path.filename(), Damaged(bytes, *seed));
      try {
        ReadWithLittleMemory(read, path);
      } catch (const Error& error) {
        if (std::strstr(error.what(), folder.Path().c_str()) == nullptr) {
          std::fprintf(stderr, "names no file: %s\n", error.what());
          _exit(1);
        }
      } catch (const OutOfMemory& error) {
        // HDF5 was refused a size that the damage made up, and under this limit memory is short.
        if (std::strstr(error.what(), folder.Path().c_str()) == nullptr) _exit(1);
      } catch (const std::exception& error) {
        std::fprintf(stderr, "not nightmap's: %s\n", error.what());
        _exit(2);
      }
    }
    _exit(0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0)
      << valid << " with damage " << *seed << ": "
      << (WIFSIGNALED(status)        ? strsignal(WTERMSIG(status))
          : WEXITSTATUS(status) == 3 ? "took too much memory"
                                     : "another error");
  munmap(shared, sizeof(std::uint64_t));
}

}  // namespace nightmap
