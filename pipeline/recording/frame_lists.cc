// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/frame_lists.h"

#include <algorithm>
#include <map>

#include "pipeline/base/error.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

constexpr std::int64_t kMaxTruthGap_ns = 100'000'000;

}  // namespace

std::optional<Rigid3> TruthAt(const std::vector<StampedPose>& truth, std::int64_t time_ns) {
  return PoseAt(truth, time_ns, kMaxTruthGap_ns);
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
    for (const Camera& image : {camera.Picture(), camera.depth}) {
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
