// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/leave_out.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "pipeline/base/input_error.h"
#include "pipeline/io/masked_pixels.h"

namespace nightmap {
namespace {

FrameFeatures Unmasked(const FrameFeatures& features,
                       const GrayImage& mask,
                       std::size_t size,
                       std::vector<int>* indices_before) {
  FrameFeatures kept;
  kept.frame_idx = features.frame_idx;
  for (std::size_t i = 0; i < features.keypoints_px.size(); ++i) {
    if (IsMasked(mask, features.raw_keypoints_px[i].cast<double>())) continue;
    indices_before->push_back(static_cast<int>(i));
    kept.keypoints_px.push_back(features.keypoints_px[i]);
    kept.raw_keypoints_px.push_back(features.raw_keypoints_px[i]);
    kept.scales_px.push_back(features.scales_px[i]);
    kept.depths_m.push_back(features.depths_m[i]);
    const auto descriptor = features.descriptors.begin() + static_cast<std::ptrdiff_t>(i * size);
    kept.descriptors.insert(
        kept.descriptors.end(), descriptor, descriptor + static_cast<std::ptrdiff_t>(size));
  }
  return kept;
}

}  // namespace

IndicesBefore LeaveOut(const std::vector<FrameRecord>& frames,
                       const std::vector<RgbdCamera>& cameras,
                       const FrameReader& masks,
                       FeaturesShard* features) {
  if (frames.size() != features->frames.size() ||
      !std::ranges::equal(
          frames, features->frames, {}, &FrameRecord::frame_idx, &FrameFeatures::frame_idx)) {
    throw InputError({{"masked_frames"}, {"features"}}, "lists other frames than the features");
  }
  const auto size = static_cast<std::size_t>(features->descriptor_size);
  IndicesBefore indices_before(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    FrameFeatures& of_frame = features->frames[i];
    const auto camera_idx = static_cast<std::size_t>(frames[i].camera_idx);
    const GrayImage mask = masks.Mask(frames[i], cameras.at(camera_idx));
    if (mask.pixels.empty() || !of_frame.IsDescribed()) {
      indices_before[i].resize(of_frame.keypoints_px.size());
      std::iota(indices_before[i].begin(), indices_before[i].end(), 0);
    } else {
      of_frame = Unmasked(of_frame, mask, size, &indices_before[i]);
    }
  }
  return indices_before;
}

}  // namespace nightmap
