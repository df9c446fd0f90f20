// SPDX-License-Identifier: Apache-2.0
// Chooses which direction is up, from how cameras are held, how they move, and what they see.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "stages/dense/map_frame/surface_patches.h"

namespace nightmap {

// Another direction less than this many times less likely makes up doubtful.
inline constexpr double kSureOfUp = 10;

struct UpChoice {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  // in the given frame, of unit length
  bool is_first = true;                           // whether it is the guess
  // How many times as likely it is as the next direction; at most 1e6, infinite without another.
  double odds = 1e6;
  // In words, as the robot sees it: "the top of the picture" or "the robot's z axis".
  std::string direction, next_direction;

  bool IsSure() const { return odds >= kSureOfUp; }
};

// Weighs UpCandidates(), `guess` among them, by
// - the robot's attitude: x forward and z up. Where no site config says how the camera is mounted
//   (`is_mount_stated`), pictures mostly stand upright, sometimes on their side or head;
// - its turns: robots turn about up, and so do people, but for looking up or down a little;
// - its way: level, where it is longer than an arm reaches;
// - surfaces: walls and floors stand at right angles; a camera that looks down sees floors, one
// that
//   looks up sees ceilings, and none sees many undersides below a ceiling.
// Each is the logarithm of how much likelier what was seen is for up than for another direction;
// no one of them decides alone. Poses in order of time, at least one. Deterministic.
UpChoice ChooseUp(const std::vector<SurfacePatch>& patches,
                  const std::vector<Rigid3>& given_from_cameras,
                  const std::vector<Rigid3>& given_from_robots,
                  bool is_mount_stated,
                  const Eigen::Vector3d& guess);

}  // namespace nightmap
