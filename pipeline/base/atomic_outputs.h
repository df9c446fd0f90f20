// SPDX-License-Identifier: Apache-2.0
// Commits the outputs of a run: all of them appear complete, or none does.
#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include "pipeline/base/writing_folder.h"

namespace nightmap {

// The outputs of one run of a stage. Each is written under its name in a WritingFolder beside its
// final place and renamed by Commit, in the order of creation, after all were flushed to disk.
// Without Commit (error, signal) the destructor removes what was written and the old files stay as
// they were. Another run that writes the same outputs at the same time writes other files: of each
// output one run's whole file stays.
class OutputSet {
 public:
  OutputSet() = default;
  ~OutputSet() = default;
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;

  // The temporary path to write for `final_path`; its folder is created. With `keep_if_equal`,
  // Commit leaves an existing file with the same bytes untouched (its time too). Throws UsageError
  // when a path is given twice, DataError when its folder cannot be made or written.
  std::filesystem::path Create(const std::filesystem::path& final_path, bool keep_if_equal = false);

  // Throws DataError when a file was not written or cannot be flushed, UsageError when something
  // else than a plain file came to be at a final path; none is renamed then.
  void Commit();

  // Final paths created so far, in order.
  std::vector<std::filesystem::path> FinalPaths() const;
  // Where the bytes of a final path are now: the temporary before Commit, itself after it.
  std::filesystem::path CurrentPath(const std::filesystem::path& final_path) const;

 private:
  struct Entry {
    std::filesystem::path final_path;
    std::filesystem::path temporary_path;
    bool keep_if_equal = false;
  };
  std::vector<Entry> entries_;
  std::map<std::filesystem::path, WritingFolder> folders_;  // of a folder with final paths
  bool committed_ = false;
};

}  // namespace nightmap
