// SPDX-License-Identifier: Apache-2.0
// Where in a window of poses a scan fits best to a likelihood field: correlative scan matching
// (Olson, Real-time correlative scan matching, ICRA 2009) by branch and bound (Hess, Kohler, Rapp,
// Andor, Real-time loop closure in 2D LIDAR SLAM, ICRA 2016).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "pipeline/laser/field_pyramid.h"

namespace nightmap {

// The poses that are tried: cell by cell about the center, and headings so dense that the points
// move by kHeadingStep_cells in the root mean square.
inline constexpr double kHeadingStep_cells = 1.5;
struct SearchWindow {
  Rigid2 center;  // field_from_robot
  double half_extent_m = 0;
  double half_angle_rad = 0;
  // Taken off a score: these times the square of the distance (m) and of the turn (rad) from the
  // center.
  double penalty_per_m2 = 0;
  double penalty_per_rad2 = 0;
  double min_value = 0;  // a pose of a smaller score, less what is taken off, is not looked for
  // Poses as near as these to this one, both in place and in heading, are left out.
  std::optional<Rigid2> not_near;
  double near_m = 0;
  double near_rad = 0;
  // Where the robot can be: in cells that are not 0 in this pyramid, which has the levels and cells
  // of the field's; null: anywhere.
  const FieldPyramid* places = nullptr;
};

struct FoundPose {
  Rigid2 field_from_robot;
  double score = 0;  // mean of level 0 of the pyramid at the points, 0 .. 1
  double value = 0;  // the score less what is taken off
};

// The pose of the window with the largest value; none: no value is above min_value. Exact: the best
// of all that are tried, and of equal ones always the same. Without points none.
std::optional<FoundPose> SearchPose(const FieldPyramid& pyramid,
                                    const std::vector<Eigen::Vector2d>& points_in_robot,
                                    const SearchWindow& window);

// All poses of the window whose value is above min_value and at least this share of the largest
// (which is positive); the best first. Exact; the order is always the same.
std::vector<FoundPose> SearchPoses(const FieldPyramid& pyramid,
                                   const std::vector<Eigen::Vector2d>& points_in_robot,
                                   const SearchWindow& window,
                                   double share_of_best);

// Headings that a window has on each side of its center, and the step between them.
struct HeadingSteps {
  int num_turns = 0;
  double step_rad = 0;
};
HeadingSteps HeadingStepsOf(const SearchWindow& window,
                            double resolution_m,
                            const std::vector<Eigen::Vector2d>& points_in_robot);

}  // namespace nightmap
