// SPDX-License-Identifier: Apache-2.0
// <job>/edges.h5: relative poses that one sensor measured, and poses in the map that are known.
// All that any sensor tells of the trajectory is of this kind, and pose_graph reads any number of
// files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"

namespace nightmap {

enum class EdgeKind : std::uint8_t {
  kOdometry = 0,  // motion from a node to a later one; always believed
  kLoop = 1,      // between any two nodes; may be wrong
  kPrior = 2,     // pose of one node in the map; always believed
};

// A node is the camera of the frame with this time_ns: the pose of the sensor on the robot is
// applied before. The covariance is of a perturbation of the pose: its three rotations (rad) first,
// then its three translations (m). It is a left perturbation, so along the axes of the target and
// about its origin; but that of a prior is along the axes of the map and about the node, so that
// its translations are those of the node however far the map's origin is. State what the sensor
// does not measure by a large variance.
struct SensorEdge {
  EdgeKind kind = EdgeKind::kOdometry;
  std::int64_t source_time_ns = 0;
  std::int64_t target_time_ns = 0;  // of a prior the same
  Rigid3 target_from_source;        // of a prior map_from_node
  Matrix6d covariance = Matrix6d::Identity();
};

// Where on the robot the sensor and the cameras were said to be when the edges were made.
struct Mounting {
  Rigid3 robot_from_sensor;
  std::vector<Rigid3> robot_from_camera;  // by camera_idx
};

struct SensorEdges {
  std::string sensor;
  std::vector<SensorEdge>
      edges;  // odometry ascends: each begins where the one before ends or later
  std::optional<Mounting> mounting = std::nullopt;
};

// Equal edges give equal bytes. Throws DataError.
void WriteEdges(const std::filesystem::path& path,
                const SensorEdges& edges,
                const std::string& config);

// Throws DataError naming file and field on sizes that do not add up, NaN, an unknown kind, an edge
// from a node to itself, an edge that is there twice, odometry that does not ascend, and a
// covariance that is not symmetric and positive definite.
SensorEdges ReadEdges(const std::filesystem::path& path);

}  // namespace nightmap
