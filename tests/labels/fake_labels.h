// SPDX-License-Identifier: Apache-2.0
// Frames, and labels that need no network.
#pragma once

#include <algorithm>

#include "pipeline/labels/labelled_frames.h"

namespace nightmap {

// 30 per second, from frame_idx 101 on.
inline std::vector<FrameRecord> FramesToLabel(int count) {
  std::vector<FrameRecord> frames;
  for (int i = 0; i < count; ++i) {
    FrameRecord& frame = frames.emplace_back();
    frame.frame_idx = 101 + i;
    frame.time_ns = 33'333'333LL * i;
    frame.color = {std::to_string(frame.frame_idx) + ".png", "hash"};
  }
  return frames;
}

// 10 x 20 pixels, the top rows of which are people, one more per frame.
inline Segmentation LabelsOf(const FrameRecord& frame, const RgbdImages&) {
  Segmentation result{{10, 20, 1, std::vector<std::uint8_t>(200)},
                      {10, 20, 1, std::vector<std::uint8_t>(200, 200)}};
  const auto num_people = static_cast<std::size_t>(10 * (frame.frame_idx - 100));
  std::fill_n(result.labels.pixels.begin(), num_people, 1);
  return result;
}

inline const SegmentationModel kModel{
    .source = "m.toml", .network = "network.onnx", .classes = {{"background", "person"}, {0, 1}}};

inline RgbdImages NoPixels(const FrameRecord&) { return {}; }

}  // namespace nightmap
