// SPDX-License-Identifier: Apache-2.0
// Keeps a recording's files inside the recording, so that a recording from an untrusted source
// cannot make the pipeline read other files of the machine.
#pragma once

#include <filesystem>
#include <string>
#include <unordered_set>
#include <vector>

#include "pipeline/recording/read_sequence.h"

namespace nightmap {

// The data folder and the paths in the site config (`root`, `folder`, `depth_folder`) may be links,
// because the user made them. A link inside the recording may lead to other places of the recording
// or of the data folder. It may lead elsewhere only at or below a name in `allow_outside`.
class RecordingBounds {
 public:
  explicit RecordingBounds(const SequenceFolder& folder);

  // Throws DataError naming the link when the file, or a folder on its path below the recording's
  // folder, is a link that leads out. `file` is relative to the data folder, normalized. A dangling
  // link passes; the file is reported missing later.
  void Check(const std::string& file);

 private:
  bool IsAllowed(const std::filesystem::path& inside) const;
  void CheckLink(const std::filesystem::path& inside) const;
  void CheckFolder(const std::string& folder);

  std::filesystem::path data_root_;
  std::string data_root_text_;    // with a trailing slash
  std::filesystem::path folder_;  // relative to data_root_
  std::string source_;
  std::vector<std::filesystem::path> allowed_;  // relative to folder_, links not followed
  std::vector<std::filesystem::path> places_;   // real paths
  std::unordered_set<std::string> checked_folders_;
};

}  // namespace nightmap
