// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/leave_out.h"

#include <algorithm>
#include <utility>

#include "pipeline/base/input_error.h"
#include "pipeline/io/masked_pixels.h"

namespace nightmap {
namespace {

std::vector<int> Unmasked(const FrameFeatures& features, const GrayImage& mask) {
  std::vector<int> left;
  for (std::size_t i = 0; i < features.keypoints_px.size(); ++i) {
    if (!IsMasked(mask, features.raw_keypoints_px[i].cast<double>())) {
      left.push_back(static_cast<int>(i));
    }
  }
  return left;
}

FrameFeatures Kept(const FrameFeatures& features, const std::vector<int>& indices, int size) {
  FrameFeatures kept;
  kept.frame_idx = features.frame_idx;
  for (const int index : indices) {
    const auto i = static_cast<std::size_t>(index);
    kept.keypoints_px.push_back(features.keypoints_px[i]);
    kept.raw_keypoints_px.push_back(features.raw_keypoints_px[i]);
    kept.scales_px.push_back(features.scales_px[i]);
    kept.depths_m.push_back(features.depths_m[i]);
    const auto descriptor = features.descriptors.begin() + std::ptrdiff_t{index} * size;
    kept.descriptors.insert(kept.descriptors.end(), descriptor, descriptor + size);
  }
  return kept;
}

}  // namespace

IndicesBefore UnmaskedFeatures(const std::vector<FrameRecord>& frames,
                               const std::vector<RgbdCamera>& cameras,
                               const FrameReader& masks,
                               const SiteFeatures& features) {
  if (!std::ranges::equal(frames,
                          features.Heads().frames,
                          {},
                          &FrameRecord::frame_idx,
                          &FrameFeatures::frame_idx)) {
    throw InputError({{"masked_frames"}, {"features"}}, "lists other frames than the features");
  }
  IndicesBefore left(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!features.Heads().frames[i].IsDescribed()) continue;
    const auto camera_idx = static_cast<std::size_t>(frames[i].camera_idx);
    const GrayImage mask = masks.Mask(frames[i], cameras.at(camera_idx));
    if (mask.pixels.empty()) continue;
    left[i] = Unmasked(*features.GetFrame(frames[i].frame_idx), mask);
  }
  return left;
}

SiteFeatures KeepFeatures(const SiteFeatures& features, IndicesBefore indices_before) {
  const int first_frame_idx = features.FirstFrame();
  return features.With(
      [first_frame_idx, indices_before = std::move(indices_before)](FeaturesShard* shard) {
        for (FrameFeatures& frame : shard->frames) {
          const auto& left =
              indices_before[static_cast<std::size_t>(frame.frame_idx - first_frame_idx)];
          if (left) frame = Kept(frame, *left, shard->descriptor_size);
        }
      });
}

}  // namespace nightmap
