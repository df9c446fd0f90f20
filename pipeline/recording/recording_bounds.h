// SPDX-License-Identifier: Apache-2.0
// Whether the files of a recording lie in it: a recording that was had from somewhere must not make
// the pipeline read what else is on the machine.
#pragma once

#include <filesystem>
#include <string>
#include <unordered_set>
#include <vector>

#include "pipeline/recording/read_sequence.h"

namespace nightmap {

// The data folder and what the site config names (`root`, `folder`, `depth_folder`) may be links:
// whoever runs the pipeline made them. A link in the recording may lead to other places of the
// recording or of the data folder, and anywhere else only at or below a name in `allow_outside`.
class RecordingBounds {
 public:
  explicit RecordingBounds(const SequenceFolder& folder);

  // Throws DataError naming the link when the file, or a folder on the way to it from the
  // recording's folder, is a link that leads out. `file` is relative to the data folder,
  // normalized. A link to nothing passes: the file will be found missing.
  void Check(const std::string& file);

 private:
  bool IsAllowed(const std::filesystem::path& inside) const;
  void CheckLink(const std::filesystem::path& inside) const;
  void CheckFolder(const std::string& folder);

  std::filesystem::path data_root_;
  std::string data_root_text_;    // with a slash at its end
  std::filesystem::path folder_;  // relative to data_root_
  std::string source_;
  std::vector<std::filesystem::path> allowed_;  // relative to folder_, without links followed
  std::vector<std::filesystem::path> places_;   // real paths
  std::unordered_set<std::string> checked_folders_;
};

}  // namespace nightmap
