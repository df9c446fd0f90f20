// SPDX-License-Identifier: Apache-2.0
// People who walk in the building while the robot records. A laser scanner sees their legs.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/world/robot_drive.h"
#include "pipeline/world/synthetic_world.h"

namespace nightmap {

// A leg is an upright cylinder from the floor on.
inline constexpr double kLegRadius_m = 0.06;
inline constexpr double kLegHeight_m = 0.9;
// The axis of a leg keeps this distance from the robot's centre.
inline constexpr double kWalkerDistance_m = 0.4;

// Walks back and forth on a straight track, at an even speed.
struct Walker {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();  // building frame, metres; from != to
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
  double floor_m = 0;
  double speed_m_per_s = 1;
  double start_m = 0;  // distance walked before time 0
};

// The axes of both legs. They swing along the track, one forward while the other is back.
std::array<Eigen::Vector2d, 2> LegsAt(const Walker& walker, double time_s);

// Tracks in free space in sight of the robot's route, spread along it. The legs touch no obstacle,
// and at no time does one come closer to the robot than kWalkerDistance_m. Throws UsageError when
// there is no place for so many walkers. Depends on the seed alone, not on threads.
std::vector<Walker> PlanWalkers(const SyntheticWorld& world,
                                const RobotDrive& drive,
                                int num_walkers,
                                std::uint64_t seed);

}  // namespace nightmap
