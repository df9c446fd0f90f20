// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/import_trajectory/pose_jumps.h"

#include <cstddef>

namespace nightmap {
namespace {

constexpr double kMinJump_m = 0.3;
constexpr double kMaxSpeed_m_s = 10;
constexpr std::int64_t kMaxAway_ns = 1'000'000'000;

bool IsJump(const StampedPose& a, const StampedPose& b) {
  const double distance_m = (b.pose.translation - a.pose.translation).norm();
  const double duration_s = 1e-9 * static_cast<double>(b.time_ns - a.time_ns);
  return distance_m > kMinJump_m && distance_m > kMaxSpeed_m_s * duration_s;
}

// The first pose after `away` that jumps back to where `before` was; 0 if none does in time.
std::size_t ReturnOf(const std::vector<StampedPose>& poses, std::size_t before, std::size_t away) {
  for (std::size_t i = away + 1; i < poses.size(); ++i) {
    if (poses[i].time_ns - poses[before].time_ns > kMaxAway_ns) return 0;
    if (IsJump(poses[i - 1], poses[i]) && !IsJump(poses[before], poses[i])) return i;
  }
  return 0;
}

}  // namespace

PoseJumps FindPoseJumps(const std::vector<StampedPose>& poses) {
  PoseJumps jumps;
  std::size_t i = 1;
  // An end of the trajectory has no pose to return to: alone beyond a jump, it counts as away.
  if (poses.size() > 2 && IsJump(poses[0], poses[1]) && !IsJump(poses[1], poses[2])) {
    jumps.away_ns.push_back(poses[0].time_ns);
    i = 2;
  }
  while (i < poses.size()) {
    if (!IsJump(poses[i - 1], poses[i])) {
      ++i;
      continue;
    }
    const bool is_last = i + 1 == poses.size();
    const std::size_t end = is_last ? i + 1 : ReturnOf(poses, i - 1, i);
    if (end == 0) {
      jumps.lasting_ns.push_back(poses[i].time_ns);
      ++i;
      continue;
    }
    for (; i < end; ++i) jumps.away_ns.push_back(poses[i].time_ns);
    ++i;
  }
  return jumps;
}

}  // namespace nightmap
