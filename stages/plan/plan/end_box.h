// SPDX-License-Identifier: Apache-2.0
// A rectangle of the map that a path starts or ends at: an object of a laser map, or a thing.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <string>

#include "pipeline/geometry/rigid2.h"

namespace nightmap {

struct EndBox {
  std::string name;
  Rigid2 map_from_box;  // the origin is the rectangle's centre
  Eigen::Vector2d size_m = Eigen::Vector2d::Zero();
  // A thing, with x pointing out of its front: the robot stands clear of it and faces it. Without a
  // front the robot may stand in the rectangle and face anywhere.
  bool has_front = false;

  // From a point to the rectangle; 0 in it.
  double Distance_m(const Eigen::Vector2d& point_in_map) const {
    return Beyond_m(point_in_map).cwiseMax(0).norm();
  }
  // Whether a point lies beyond the front and no farther beyond a side.
  bool IsInFront(const Eigen::Vector2d& point_in_map) const {
    const Eigen::Vector2d beyond_m = Beyond_m(point_in_map);
    const bool is_ahead = (map_from_box.Inverse() * point_in_map).x() > 0;
    return is_ahead && beyond_m.x() > 0 && beyond_m.x() >= beyond_m.y();
  }
  // In which a robot at a point looks at the centre.
  double HeadingFrom_rad(const Eigen::Vector2d& point_in_map) const {
    const Eigen::Vector2d way = map_from_box.translation - point_in_map;
    return std::atan2(way.y(), way.x());
  }

 private:
  // How far a point is beyond the rectangle's sides across x and across y; negative within them.
  Eigen::Vector2d Beyond_m(const Eigen::Vector2d& point_in_map) const {
    return (map_from_box.Inverse() * point_in_map).cwiseAbs() - size_m / 2;
  }
};

}  // namespace nightmap
