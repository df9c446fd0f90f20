// SPDX-License-Identifier: Apache-2.0
// Matches of random points with a camera at a random pose.
#pragma once

#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/geometry/absolute_pose.h"

namespace nightmap {

inline const Camera kCamera{640, 480, 525, 525, 319.5, 239.5};

inline Rigid3 RandomPose(Random& random) {
  const Eigen::Vector3d axis(random.Gaussian(), random.Gaussian(), random.Gaussian());
  return {Eigen::Quaterniond(Eigen::AngleAxisd(random.Uniform(-3, 3), axis.normalized())),
          {random.Uniform(-9, 9), random.Uniform(-9, 9), random.Uniform(-1, 1)}};
}

inline PointMatch MatchOf(const Rigid3& camera_from_world, const Eigen::Vector3d& point_in_camera) {
  return {*kCamera.ProjectUndistorted(point_in_camera),
          camera_from_world.Inverse() * point_in_camera,
          0,
          0};
}

inline Eigen::Vector3d RandomPoint(Random& random) {
  return kCamera.BackProjectUndistorted({random.Uniform(0, 639), random.Uniform(0, 479)},
                                        random.Uniform(1, 4));
}

// Matches of which the first num_outliers have a pixel that fits nothing.
inline std::vector<PointMatch> MakeMatches(const Rigid3& camera_from_world,
                                           int num_matches,
                                           int num_outliers,
                                           Random& random) {
  std::vector<PointMatch> matches;
  for (int i = 0; i < num_matches; ++i) {
    matches.push_back(MatchOf(camera_from_world, RandomPoint(random)));
    if (i < num_outliers) matches.back().pixel = {random.Uniform(0, 639), random.Uniform(0, 479)};
  }
  return matches;
}

}  // namespace nightmap
