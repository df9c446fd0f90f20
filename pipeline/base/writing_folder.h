// SPDX-License-Identifier: Apache-2.0
// A folder for the files of one run until they are complete.
#pragma once

#include <filesystem>

namespace nightmap {

// Makes a folder `.writing.<host>.<random>` in another, of its own for each run, so that two runs
// never write one file. A run that is killed leaves its folder behind; the next run on this host
// removes it. It knows from a lock, which each run holds on its folder and which ends with the
// process, that nobody writes there. Folders of other hosts are left alone: a lock may not reach so
// far. A file is renamed from here to its final place in one step, on one file system.
class WritingFolder {
 public:
  // Throws DataError when the folder cannot be made.
  explicit WritingFolder(const std::filesystem::path& folder);
  // Removes the folder and what is left in it.
  ~WritingFolder();
  WritingFolder(const WritingFolder&) = delete;
  WritingFolder& operator=(const WritingFolder&) = delete;

  const std::filesystem::path& Path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;
};

}  // namespace nightmap
