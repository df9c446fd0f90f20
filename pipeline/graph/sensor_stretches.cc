// SPDX-License-Identifier: Apache-2.0
#include "pipeline/graph/sensor_stretches.h"

#include <optional>

namespace nightmap {
namespace {

constexpr double kLength_m = 0.5;
constexpr double kTurn_rad = 0.35;
constexpr std::int64_t kMaxTime_ns = 5'000'000'000;

SensorStretch MakeStretch(const CameraRun& run, const PoseEdge& edge) {
  const auto time_of = [&](int frame_idx) {
    return run.poses[static_cast<std::size_t>(frame_idx - run.first_frame)].time_ns;
  };
  return {&run, time_of(edge.frame_a), time_of(edge.frame_b), edge.b_from_a, edge.covariance};
}

}  // namespace

std::vector<SensorStretch> FindSensorStretches(const std::vector<CameraRun>& runs,
                                               const std::vector<PoseEdge>& odometry) {
  std::vector<SensorStretch> stretches;
  std::optional<PoseEdge> open;
  for (const PoseEdge& step : odometry) {
    open = open && open->frame_b == step.frame_a ? Chained(*open, step) : step;
    const CameraRun* run = RunOf(runs, open->frame_a, open->frame_b);
    if (!run) {
      open.reset();
      continue;
    }
    const bool is_far = open->b_from_a.translation.norm() >= kLength_m ||
                        AngleBetween_rad(open->b_from_a, {}) >= kTurn_rad;
    const SensorStretch stretch = MakeStretch(*run, *open);
    const bool is_slow = stretch.target_ns - stretch.source_ns > kMaxTime_ns;
    if (is_far && !is_slow) stretches.push_back(stretch);
    if (is_far || is_slow) open.reset();
  }
  return stretches;
}

}  // namespace nightmap
