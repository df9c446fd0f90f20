// SPDX-License-Identifier: Apache-2.0
// Poses of a robot and corners of a ceiling that agree best with pictures and wheels: least squares
// over all of them at once.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pipeline/base/progress.h"
#include "pipeline/ceiling/ceiling_noise.h"
#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid2.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

using Vector5d = Eigen::Matrix<double, 5, 1>;

// The unknowns. The map's frame is that of the first keyframe, which stays where it is.
struct CeilingUnknowns {
  // x, y (m), heading (rad) of map_from_robot; then the tilt (rad) of the robot in this frame,
  // about the camera's x and y.
  std::vector<Vector5d> keyframes;
  std::vector<Eigen::Vector3d> points;  // metres, in the map
  // The mounting beyond what robot_from_camera says: a rotation vector (rad) in the camera's frame,
  // then x, y (m) in the robot's. Its height cannot be told from that of the ceiling.
  Vector5d mounting = Vector5d::Zero();
  // True distance = (1 + scale error) * that of the wheels; heading error in rad per metre.
  Eigen::Vector2d wheels = Eigen::Vector2d::Zero();
  double level_m = 0;  // height of the points of `level`
};

struct PointSighting {
  std::size_t keyframe = 0;
  std::size_t point = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // undistorted
};

// The robot's motion between keyframes `start` and `start` + 1.
struct KeyframeMotion {
  std::size_t start = 0;
  Rigid2 before_from_after;
  double distance_m = 0;
  double turn_rad = 0;
  bool is_measured = true;  // by the wheels; else it is a guess
  double time_s = 0;
};

// A ceiling whose height somebody measured.
struct KnownLevel {
  double height_m = 0;
  double sigma_m = 0;
  std::vector<std::size_t> points;
};

struct CeilingProblem {
  Camera camera;
  Rigid3 robot_from_camera;
  std::vector<PointSighting> sightings;
  std::vector<KeyframeMotion> motions;
  std::optional<KnownLevel> level;
};

struct CeilingSolution {
  int num_iterations = 0;
  bool has_converged = false;
  double initial_cost = 0, final_cost = 0;
  double median_error_px = 0;  // of the sightings
};

// Gauss and Newton over all unknowns at once, with Marquardt's damping (1963) where a step does not
// lower the cost. Sightings have a Cauchy loss, wheels a Huber loss, both by weights that every
// step sets anew: a corner that jumped and wheels that slipped move nothing. A first solution with
// a wide loss of the sightings moves what a loop has to move. Sightings come in the order of their
// keyframes, of which each but the first has one motion that leads to it. Progress is by steps.
// Throws DataError when a landmark is not above a camera that saw it, no step lowers the cost, or
// the system does not fit into memory. Deterministic; one thread.
CeilingSolution SolveCeiling(const CeilingNoise& noise,
                             const CeilingProblem& problem,
                             Progress& progress,
                             CeilingUnknowns* unknowns);

}  // namespace nightmap
