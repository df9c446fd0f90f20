// SPDX-License-Identifier: Apache-2.0
// Pose graphs in the g2o format: VERTEX_SE3:QUAT (map_from_camera), EDGE_SE3:QUAT (a_from_b with
// the upper triangle of its information, translation first, rotation as quaternion vector part),
// FIX.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/odometry_io.h"

namespace nightmap {

struct PoseGraph {
  struct Vertex {
    int frame_idx = 0;
    Rigid3 map_from_camera;
  };
  std::vector<Vertex> vertices;  // ascending frame_idx
  std::vector<PoseEdge> edges;   // frame_a and frame_b name vertices
};

// The first vertex is fixed.
std::string PoseGraphToG2o(const PoseGraph& graph);
// Throws DataError naming file and line on an unknown tag, a wrong count, NaN, a repeated vertex or
// an edge to a missing vertex. The format does not store is_bridge.
PoseGraph ReadG2o(const std::filesystem::path& path);

}  // namespace nightmap
