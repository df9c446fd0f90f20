// SPDX-License-Identifier: Apache-2.0
// Pixels of points for a camera on a robot that drives on a floor, with derivatives.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

using Matrix23d = Eigen::Matrix<double, 2, 3>;
using Matrix32d = Eigen::Matrix<double, 3, 2>;

// Frames: the map's (z up, floor at z = 0), the robot's (x forward, y left, z up, origin on the
// floor), the camera's. `pose` is x, y (m), heading (rad) of map_from_robot. The camera is turned
// by a small `tilt` against its mounting: rotation vector about its own x and y, in rad, so that
//   map_from_camera = map_from_robot * robot_from_camera * (rotation exp(tilt_x, tilt_y, 0)).
class UpwardCamera {
 public:
  // Pixels are undistorted, of a pinhole with the camera's fx fy cx cy.
  UpwardCamera(const Camera& camera, const Rigid3& robot_from_camera)
      : camera_(camera), robot_from_camera_(robot_from_camera) {}

  struct Projection {
    Eigen::Vector2d pixel;
    double depth_m = 0;
    Matrix23d by_pose;
    Eigen::Matrix2d by_tilt;
    Matrix23d by_point;
  };
  // None for a point that is not in front of the camera.
  std::optional<Projection> Project(const Eigen::Vector3d& pose,
                                    const Eigen::Vector2d& tilt_rad,
                                    const Eigen::Vector3d& point) const;

  struct RayPoint {
    Eigen::Vector3d point;
    Eigen::Matrix3d by_pose;
    Matrix32d by_tilt;
    Matrix32d by_pixel;
    Eigen::Vector3d by_depth;
  };
  // The point that is seen at `pixel` at depth z.
  RayPoint PointAt(const Eigen::Vector3d& pose,
                   const Eigen::Vector2d& tilt_rad,
                   const Eigen::Vector2d& pixel,
                   double depth_m) const;

  // Depth, in the second view, of the point that is nearest to the rays of both views: with level
  // cameras that is Z = f T / (x1 - x2) of the publication. None for rays that meet at less than
  // `min_parallax_rad`, as in a turn on the spot, or behind a camera.
  struct View {
    Eigen::Vector3d pose;
    Eigen::Vector2d tilt_rad;
    Eigen::Vector2d pixel;
  };
  std::optional<double> Triangulate(const View& first,
                                    const View& second,
                                    double min_parallax_rad) const;

 private:
  Camera camera_;
  Rigid3 robot_from_camera_;
};

}  // namespace nightmap
