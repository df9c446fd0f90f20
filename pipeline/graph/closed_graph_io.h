// SPDX-License-Identifier: Apache-2.0
// pose_graph/graph.h5: the pose graph with its loops closed, exactly as pose_graph left it.
//
// HDF5, for F frames, K keyframes, E edges, L loop candidates, S sensors, B filled bridges:
//   sensors               text             JSON list of the ids of the S sensors beside the camera
//   sigma_floor           double[2]        EdgeSigmaFloor: m, rad
//   odometry_from_camera  double[F x 7]    OdometryChain: tx ty tz (metres) qx qy qz qw
//   is_guessed            uint8[F]         whether the frame has no verified pair
//   keyframe_idx          int32[K]         ascending, from 0
//   graph_from_keyframe   double[K x 7]    optimized
//   edge_kind             uint8[E]         0 odometry, 1 bridge, 2 bridge that loops replace, 3
//   loop, 4 prior edge_sensor           int32[E]         index of the sensor; -1: the camera
//   edge_frame            int32[E x 2]     a, b; a is -1, the map, of a prior
//   edge_b_from_a         double[E x 7]
//   edge_covariance       double[E x 36]   of the camera with the floor, of others as measured
//   is_loop_accepted      uint8[L]         by pair of loops.h5
//   filled_bridge         int32[B x 2]     keyframe after the bridge, index of the sensor
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "pipeline/graph/sensor_edges.h"

namespace nightmap {

struct ClosedGraph {
  EdgeSigmaFloor floor;
  OdometryChain chain;                        // with the bridges that sensors measured filled
  std::set<int> replaced_bridges;             // by loops; by the keyframe after the bridge
  std::vector<SensorGraph> sensors;           // all their odometry and priors, accepted loops
  FilledBridges filled;                       // index into `sensors`
  std::map<int, Rigid3> graph_from_keyframe;  // of all keyframes of the chain
  std::vector<bool> is_loop_accepted;         // of the camera's loops, by pair of loops.h5
};

// Equal graphs give equal bytes, and all doubles are read back as they were. Throws DataError.
void WriteClosedGraph(const std::filesystem::path& path,
                      const ClosedGraph& graph,
                      const std::string& config);

// Throws DataError naming file and field on sizes that do not add up, NaN, an unknown kind or
// sensor, edges between frames that there are not, and odometry that is no chain of keyframes.
ClosedGraph ReadClosedGraph(const std::filesystem::path& path);

}  // namespace nightmap
