// SPDX-License-Identifier: Apache-2.0
// <job>/ceiling_map.h5: the landmarks of a ceiling, and what the filter said at each frame.
//
// HDF5, for F frames, A anchors, L landmarks, C loops, M tracks; the map's frame is the robot's at
// its start (x forward, y left, z up, floor at z = 0):
//   frame_time_ns           int64[F]
//   frame_pose              double[F x 3]   x, y (m), heading (rad) by what was known at that frame
//   frame_covariance        double[F x 9]   of these
//   frame_nis               double[F]       normalized innovation squared of its sightings
//   frame_num_residuals     int32[F]        degrees of freedom of it
//   frame_num_misfits       int32[F]        sightings that did not fit
//   frame_flags             uint8[F]        1: without odometry; 2: wheels slipped
//   anchor_pose             double[A x 3]   x, y (m), heading (rad), by all that is known
//   anchor_covariance       double[A x 9]
//   landmark_track_id       int64[L]
//   landmark_anchor         int32[L]
//   landmark_position_m     double[L x 3]   in the map
//   landmark_covariance_m2  double[L x 9]
//   landmark_num_sightings  int32[L]
//   landmark_last_time_ns   int64[L]        frame that saw it last, and where
//   landmark_last_raw_px    float[L x 2]
//   loop_anchors            int32[C x 2]    now, then
//   loop_num_landmarks      int32[C]
//   met_again_track_id      int64[M x 2]    a track that saw a landmark again, the landmark's
//   mounting                double[1 x 5]   see CeilingMap
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

struct CeilingFrame {
  std::int64_t time_ns = 0;
  Rigid2 map_from_robot;                                 // by all that is known; the trajectory
  Rigid2 map_from_robot_then;                            // by what was known at this frame
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of the latter
  double nis = 0;
  int num_residuals = 0;
  int num_misfits = 0;
  bool has_odometry = true;
  bool has_slipped = false;
};

struct CeilingLandmark {
  std::int64_t track_id = 0;
  int anchor = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // in the map
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  int num_sightings = 0;
  std::int64_t last_time_ns = 0;
  Eigen::Vector2f last_raw_px = Eigen::Vector2f::Zero();
};

struct CeilingAnchor {
  Rigid2 map_from_anchor;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of x, y, heading
};

struct CeilingLoop {
  int now = 0;  // anchors
  int then = 0;
  int num_landmarks = 0;
};

// A landmark has the id of the track that saw it first.
struct MetAgain {
  std::int64_t track_id = 0;
  std::int64_t landmark_track_id = 0;
};

struct CeilingMap {
  std::vector<CeilingFrame> frames;  // times ascend
  std::vector<CeilingAnchor> anchors;
  std::vector<CeilingLandmark> landmarks;
  std::vector<CeilingLoop> loops;
  std::vector<MetAgain> met_again;
  // The camera's mounting beyond what the site config says: a rotation vector (rad) in the camera's
  // frame, then x, y (m) in the robot's.
  Eigen::Matrix<double, 5, 1> mounting = Eigen::Matrix<double, 5, 1>::Zero();
};

// robot_from_camera with the map's mounting.
Rigid3 MountedAs(const Rigid3& robot_from_camera, const CeilingMap& map);

// Equal maps give equal bytes. Throws DataError. The trajectory is not in it.
void WriteCeilingMap(const std::filesystem::path& path,
                     const CeilingMap& map,
                     const std::string& config);

// Frames have `map_from_robot_then` for `map_from_robot`. Throws DataError naming file and field on
// sizes that do not add up, NaN, frames that do not ascend, an index of no anchor, and a landmark
// that is there twice or was met again and is not there.
CeilingMap ReadCeilingMap(const std::filesystem::path& path);

// A PLY of points with the color of their height and the property sigma_m, of the worst direction.
std::string LandmarksToPly(const std::vector<CeilingLandmark>& landmarks);

}  // namespace nightmap
