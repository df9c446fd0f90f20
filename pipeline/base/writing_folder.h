// SPDX-License-Identifier: Apache-2.0
// A folder for the files of one run while they are incomplete.
#pragma once

#include <filesystem>

namespace nightmap {

// Makes a folder `.writing.<host>.<random>` in another, distinct for each run, so that two runs
// never write one file. A killed run leaves its folder behind, and the next run on this host
// removes it. Each run holds a lock on its folder that ends with the process; a free lock shows
// that nobody writes there. Folders of other hosts stay, because a lock may not reach other hosts.
// Renaming a file from here to its final place is one step within one file system.
class WritingFolder {
 public:
  // Throws DataError when the folder cannot be made.
  explicit WritingFolder(const std::filesystem::path& folder);
  // Removes the folder and its remaining files.
  ~WritingFolder();
  WritingFolder(const WritingFolder&) = delete;
  WritingFolder& operator=(const WritingFolder&) = delete;

  const std::filesystem::path& Path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;
};

}  // namespace nightmap
