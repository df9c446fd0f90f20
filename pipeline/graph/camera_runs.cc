// SPDX-License-Identifier: Apache-2.0
#include "pipeline/graph/camera_runs.h"

#include <algorithm>
#include <iterator>
#include <limits>

#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

bool GoesOn(const CameraRun& run, const FrameRecord& before, const FrameRecord& frame) {
  return run.Has(before.frame_idx) && before.sequence_idx == frame.sequence_idx &&
         before.camera_idx == frame.camera_idx && before.time_ns < frame.time_ns;
}

}  // namespace

Rigid3 CameraRun::At(std::int64_t time_ns) const {
  const std::int64_t time_in_run_ns =
      std::clamp(time_ns, poses.front().time_ns, poses.back().time_ns);
  return PoseAt(poses, time_in_run_ns, std::numeric_limits<std::int64_t>::max()).value();
}

std::vector<CameraRun> FindCameraRuns(const std::vector<FrameRecord>& frames,
                                      const OdometryChain& chain) {
  std::vector<CameraRun> runs;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const int idx = frames[i].frame_idx;
    if (chain.guessed.contains(idx)) continue;
    const bool goes_on = !runs.empty() && !chain.after_bridge.contains(idx) &&
                         GoesOn(runs.back(), frames[i - 1], frames[i]);
    if (!goes_on) runs.push_back({idx, frames[i].camera_idx, {}});
    runs.back().poses.push_back({frames[i].time_ns, chain.At(idx)});
  }
  return runs;
}

const CameraRun* RunOf(const std::vector<CameraRun>& runs, int frame_a, int frame_b) {
  const auto next = std::ranges::upper_bound(runs, frame_a, {}, &CameraRun::first_frame);
  if (next == runs.begin()) return nullptr;
  const CameraRun& run = *std::prev(next);
  return run.Has(frame_a) && run.Has(frame_b) ? &run : nullptr;
}

}  // namespace nightmap
