// SPDX-License-Identifier: Apache-2.0
// Pixels of frames as a map may use them: without what moves by itself, where masks say what does.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "pipeline/io/frames_io.h"

namespace nightmap {

// The channel of a frame that names its mask: the file of masks that holds it, and its hash.
constexpr const char* kMaskChannel = "mask";

// Takes what moves out of the pixels of a frame (masked_pixels.h), and notes where it was. Throws
// DataError when the sizes differ.
void MaskOut(GrayImage moving, RgbdImages* images);

// Several threads may read at once. Throws as LoadColor and LoadDepth do, and ArtifactError naming
// file and frame when a mask is missing or of another size.
class FrameReader {
 public:
  // `mask_files`: those that the frames' mask channel may name, in any order; none: what moves is
  // not asked. A file is read when its first frame is.
  explicit FrameReader(std::filesystem::path data_root,
                       const std::vector<std::filesystem::path>& mask_files = {});

  // Whether what moves in the frame is known. True without mask files.
  bool MayUse(const FrameRecord& frame) const;
  // 255 where something moves; empty where nothing is known.
  GrayImage Mask(const FrameRecord& frame, const RgbdCamera& camera) const;
  // Masked colors are faded out, masked depth is 0 (masked_pixels.h).
  ColorImage Color(const FrameRecord& frame, const RgbdCamera& camera) const;
  DepthImage Depth(const FrameRecord& frame, const RgbdCamera& camera) const;
  RgbdImages Rgbd(const FrameRecord& frame, const RgbdCamera& camera) const;

 private:
  struct MaskFiles;
  std::filesystem::path data_root_;
  std::shared_ptr<MaskFiles> masks_;  // of all copies
};

}  // namespace nightmap
