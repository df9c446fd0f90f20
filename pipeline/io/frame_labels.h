// SPDX-License-Identifier: Apache-2.0
// Labels of frames, from the files that lists of frames name.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/io/frames_io.h"
#include "pipeline/io/labels_io.h"

namespace nightmap {

// The channel of a frame that names the file with its labels, and their hash.
constexpr const char* kLabelsChannel = "labels";

// Several threads may read at once.
class FrameLabels {
 public:
  // `files`: those that the frames' labels channel may name, in any order, at least one. A file is
  // opened when its first frame is read. Throws ArtifactError naming the first when it cannot be
  // read.
  explicit FrameLabels(const std::vector<std::filesystem::path>& files);

  // Names of the classes. The hashes of the labels stand for them, too.
  const std::vector<std::string>& Classes() const;
  // Throws ArtifactError naming the file when the labels are missing, damaged, of another size than
  // `picture`, or of other classes than those of the first file.
  Segmentation Of(const FrameRecord& frame, const Camera& picture) const;

 private:
  struct Files;
  std::shared_ptr<Files> files_;  // of all copies
};

}  // namespace nightmap
