// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_adjust/adjusted_frames.h"

#include <cmath>

namespace nightmap {

std::vector<std::size_t> ChooseKeyframes(const std::vector<Rigid2>& map_from_robot,
                                         double distance_m,
                                         double turn_rad) {
  std::vector<std::size_t> keyframes;
  for (std::size_t i = 0; i < map_from_robot.size(); ++i) {
    bool is_keyframe = keyframes.empty() || i + 1 == map_from_robot.size();
    if (!is_keyframe) {
      const Rigid2 moved = map_from_robot[keyframes.back()].Inverse() * map_from_robot[i];
      is_keyframe =
          moved.translation.norm() >= distance_m || std::abs(moved.heading_rad) >= turn_rad;
    }
    if (is_keyframe) keyframes.push_back(i);
  }
  return keyframes;
}

std::vector<Rigid2> CarryFrames(const std::vector<Rigid2>& map_from_robot,
                                const std::vector<std::int64_t>& times_ns,
                                const std::vector<std::size_t>& keyframes,
                                const std::vector<Rigid2>& adjusted) {
  std::vector<Rigid2> carried = map_from_robot;
  for (std::size_t k = 0; k < keyframes.size(); ++k) carried[keyframes[k]] = adjusted[k];
  for (std::size_t k = 1; k < keyframes.size(); ++k) {
    const std::size_t a = keyframes[k - 1], b = keyframes[k];
    for (std::size_t i = a + 1; i < b; ++i) {
      const Rigid2 by_a = adjusted[k - 1] * (map_from_robot[a].Inverse() * map_from_robot[i]);
      const Rigid2 by_b = adjusted[k] * (map_from_robot[b].Inverse() * map_from_robot[i]);
      const double share = static_cast<double>(times_ns[i] - times_ns[a]) /
                           static_cast<double>(times_ns[b] - times_ns[a]);
      const double turn_rad = WrapAngle_rad(by_b.heading_rad - by_a.heading_rad);
      carried[i] = {WrapAngle_rad(by_a.heading_rad + share * turn_rad),
                    by_a.translation + share * (by_b.translation - by_a.translation)};
    }
  }
  return carried;
}

}  // namespace nightmap
