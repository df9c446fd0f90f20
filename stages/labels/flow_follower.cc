// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/flow_follower.h"

#include "pipeline/features/extract_features.h"

namespace nightmap {
namespace {

const Camera& CameraOf(const std::vector<RgbdCamera>& cameras, const FrameRecord& frame) {
  return cameras.at(static_cast<std::size_t>(frame.camera_idx)).color;
}

}  // namespace

FlowFollower::FlowFollower(const std::vector<RgbdCamera>& cameras)
    : cameras_(cameras), tracker_(TrackingOptions{}) {}

void FlowFollower::Start(const FrameRecord& frame,
                         const ColorImage& color,
                         const GrayImage& moving) {
  ExtractionOptions corners;
  corners.detector = "fast_orb";
  const Camera& camera = CameraOf(cameras_, frame);
  tracker_.Start(color, camera, ExtractFeatures(color, camera, corners, moving));
  camera_idx_ = frame.camera_idx;
}

bool FlowFollower::Follows(const FrameRecord& frame, const ColorImage& color) {
  if (frame.camera_idx != camera_idx_) return false;
  return tracker_.Track(color, CameraOf(cameras_, frame), frame.frame_idx).has_value();
}

}  // namespace nightmap
