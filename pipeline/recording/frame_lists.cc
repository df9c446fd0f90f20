// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/frame_lists.h"

#include <algorithm>
#include <map>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

constexpr std::int64_t kMaxTruthGap_ns = 100'000'000;

}  // namespace

std::optional<Rigid3> TruthAt(const std::vector<StampedPose>& truth, std::int64_t time_ns) {
  const auto next = std::ranges::lower_bound(truth, time_ns, {}, &StampedPose::time_ns);
  if (next == truth.end()) return std::nullopt;
  if (next->time_ns == time_ns) return next->pose;
  if (next == truth.begin()) return std::nullopt;
  const StampedPose& a = *std::prev(next);
  const StampedPose& b = *next;
  if (b.time_ns - a.time_ns > kMaxTruthGap_ns) return std::nullopt;
  const double ratio =
      static_cast<double>(time_ns - a.time_ns) / static_cast<double>(b.time_ns - a.time_ns);
  return Rigid3{a.pose.rotation.slerp(ratio, b.pose.rotation),
                a.pose.translation + ratio * (b.pose.translation - a.pose.translation)};
}

void NumberFrames(std::vector<FrameWithTruth> all,
                  std::vector<FrameRecord>* frames,
                  std::vector<StampedPose>* truth) {
  for (FrameWithTruth& one : all) {
    one.frame.frame_idx = static_cast<int>(frames->size());
    if (one.truth) truth->push_back({one.frame.time_ns, *one.truth});
    frames->push_back(std::move(one.frame));
  }
}

std::vector<RgbdCamera> KeepUsedCameras(const std::vector<RgbdCamera>& cameras,
                                        std::vector<FrameRecord>* frames) {
  std::map<int, int> kept_idx;
  for (const FrameRecord& frame : *frames) kept_idx[frame.camera_idx] = 0;
  std::vector<RgbdCamera> kept;
  for (auto& [camera_idx, idx] : kept_idx) {
    idx = static_cast<int>(kept.size());
    kept.push_back(cameras.at(static_cast<std::size_t>(camera_idx)));
  }
  for (FrameRecord& frame : *frames) frame.camera_idx = kept_idx.at(frame.camera_idx);
  return kept;
}

void CheckAreas(const std::vector<RgbdCamera>& cameras, double max_picture_mpx) {
  for (const RgbdCamera& camera : cameras) {
    for (const Camera& image : {camera.color, camera.depth}) {
      if (1e-6 * image.width * image.height <= max_picture_mpx) continue;
      throw DataError(
          "camera of {}: {} x {} pixels are more than max_picture_mpx = {}: correct the camera in "
          "the site config or cameras.csv, or raise max_picture_mpx of frames and queries",
          camera.camera_id,
          image.width,
          image.height,
          max_picture_mpx);
    }
  }
}

}  // namespace nightmap
