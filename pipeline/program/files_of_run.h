// SPDX-License-Identifier: Apache-2.0
// The files that one run reads and writes, so that it overwrites no input and writes no file twice.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <string>
#include <utility>

namespace nightmap {

// A path stands for the file that it leads to, however it is written: `q`, `./q` and `link/q` are
// one output, and a hard link to an input is that input. Roles name paths in messages, as in
// "--out png=map.png".
class FilesOfRun {
 public:
  // Throws UsageError when the file is also written.
  void AddRead(const std::filesystem::path& path, const std::string& role);

  // Throws UsageError when a file cannot be put there (RequirePlaceForFile), when it is also read,
  // when another output is the same file, or is a folder of it.
  void AddWritten(const std::filesystem::path& path, const std::string& role);

 private:
  using Identity = std::pair<dev_t, ino_t>;
  std::map<Identity, std::string> read_;                  // role of each file
  std::map<Identity, std::string> overwritten_;           // role of what is there already
  std::map<std::filesystem::path, std::string> written_;  // role of each resolved path
};

}  // namespace nightmap
