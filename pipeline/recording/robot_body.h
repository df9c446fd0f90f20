// SPDX-License-Identifier: Apache-2.0
// The robot in the scans of its own laser: directions in which the range stays while everything
// else changes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/recording/beam_fan.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

struct RobotBody {
  BeamFan directions;          // of the beams of a scan that has as many as most
  std::vector<float> range_m;  // of the robot in each direction; NaN where it is not seen
  float margin_m = 0;          // a range of the robot may be so much larger or smaller

  double share = 0;  // of the directions, that show the robot
  double largest_range_m = 0;
  std::vector<int> sectors_deg;  // that hold them, as blind_deg of a [[sensor]]
  std::string remedy;            // the line to write in the [[sensor]]: min_range_m or blind_deg
  // Whether it can be no wall along which the robot drove at one distance. Such a wall is long, and
  // its range is another as often as the robot turns or wavers.
  bool is_certain = false;
};

// None where too few scans differ from each other to tell; a share of 0 where the robot is not
// seen. Scans count that differ from all that were chosen before, in a fifth of the directions or
// more. So a robot that stands, or drives along a corridor, whose walls stay at one distance, gives
// few of them; and one that turns, to which all walls move, gives many. They are from all over the
// drive. Pure.
std::optional<RobotBody> FindRobotBody(const std::vector<SignalSample>& scans);

// Takes for not measured, in the directions of the robot, all but hits beyond it: what is nearer
// cannot be a wall, and a beam without a return may have been lost on the robot. A hit beyond it is
// true, of a part that moved away. In the directions beside, within a beam or a degree, where
// beams are split between the robot and what is behind, it takes hits at the robot's range. Pure.
void LeaveOut(const RobotBody& body, std::vector<SignalSample>* scans);

}  // namespace nightmap
