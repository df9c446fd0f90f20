// SPDX-License-Identifier: Apache-2.0
// Commits the outputs of a run: all of them appear complete, or none does.
#pragma once

#include <filesystem>
#include <map>
#include <vector>

#include "pipeline/base/writing_folder.h"

namespace nightmap {

// The outputs of one run of a stage. Each is written under its name in a WritingFolder next to its
// final place. Commit flushes all to disk, then renames them in the order of creation. Without
// Commit (error, signal) the destructor removes what was written, and the old files stay. A
// concurrent run with the same outputs writes other temporary files, so each output is one run's
// whole file.
class OutputSet {
 public:
  OutputSet() = default;
  ~OutputSet() = default;
  OutputSet(const OutputSet&) = delete;
  OutputSet& operator=(const OutputSet&) = delete;

  // Returns the temporary path to write for `final_path` and creates its folder. With
  // `keep_if_equal`, Commit leaves an existing file with the same bytes untouched (its time too).
  // Throws UsageError when a path is given twice, DataError when its folder cannot be made or
  // written.
  std::filesystem::path Create(const std::filesystem::path& final_path, bool keep_if_equal = false);

  // Throws DataError when a file was not written or cannot be flushed, UsageError when a final path
  // holds something other than a plain file. It then renames none.
  void Commit();

  // Final paths created so far, in order.
  std::vector<std::filesystem::path> FinalPaths() const;
  // Where the bytes of a final path are now: the temporary path before Commit, the final path after
  // it.
  std::filesystem::path CurrentPath(const std::filesystem::path& final_path) const;

 private:
  struct Entry {
    std::filesystem::path final_path;
    std::filesystem::path temporary_path;
    bool keep_if_equal = false;
  };
  std::vector<Entry> entries_;
  std::map<std::filesystem::path, WritingFolder> folders_;  // by folder of final paths
  bool committed_ = false;
};

}  // namespace nightmap
