// SPDX-License-Identifier: Apache-2.0
// The files that one run reads and writes; ensures that it overwrites no input and writes no file
// twice.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <string>
#include <utility>

namespace nightmap {

// A path stands for the file that it leads to, however it is spelled: `q`, `./q` and `link/q` are
// one output, and a hard link to an input is that input. Roles name paths in messages, as in "--out
// png=map.png".
class FilesOfRun {
 public:
  // Throws UsageError when the file is also written.
  void AddRead(const std::filesystem::path& path, const std::string& role);

  // Throws UsageError when a file cannot be put there (RequirePlaceForFile), when it is also read,
  // or when another output is the same file or a folder of it.
  void AddWritten(const std::filesystem::path& path, const std::string& role);

 private:
  using Identity = std::pair<dev_t, ino_t>;
  std::map<Identity, std::string> read_;                  // role by file
  std::map<Identity, std::string> overwritten_;           // role by existing file
  std::map<std::filesystem::path, std::string> written_;  // role by resolved path
};

}  // namespace nightmap
