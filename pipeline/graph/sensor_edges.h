// SPDX-License-Identifier: Apache-2.0
// Edges of other sensors (wheels, scans, surveyed poses) between frames, and moved to keyframes.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/graph/odometry_chain.h"
#include "pipeline/io/edges_io.h"

namespace nightmap {

// Source of a prior: the map, a node at the identity that is no frame.
constexpr int kMapNode = -1;

// All edges of one sensor, between frames. Covariances are as measured, without the floor.
struct SensorGraph {
  std::string sensor;
  std::vector<PoseEdge> odometry;  // ascending: each begins where the one before ends, or later
  std::vector<PoseEdge> loops;     // from the earlier frame to the later one
  std::vector<PoseEdge> priors;    // from kMapNode to a frame: camera_from_map
  std::optional<Mounting> mounting = std::nullopt;
};

// The sensors that measured motions to keyframes that the camera only guessed; by that keyframe.
using FilledBridges = std::map<int, std::size_t>;

// Consecutive steps of a sensor as one edge.
struct Stretch {
  PoseEdge edge;
  std::vector<PoseEdge> steps;
};

// Cuts the steps at the nodes nearest to keyframes.
std::vector<Stretch> CutAtKeyframes(const OdometryChain& chain,
                                    const std::set<int>& keyframes,
                                    const std::vector<PoseEdge>& steps);

// The edge between the keyframes nearest to its frames, or from the map to the one of a prior, with
// the floor; none: both are one keyframe, or the camera only guessed the motion to them.
std::optional<PoseEdge> AtKeyframes(const EdgeSigmaFloor& floor,
                                    const OdometryChain& chain,
                                    const std::set<int>& keyframes,
                                    const PoseEdge& edge);

// The edges believed without a test: odometry of all sensors, chained from keyframe to keyframe
// (without what fills a bridge), then their priors.
std::vector<PoseEdge> MeasuredBySensors(const EdgeSigmaFloor& floor,
                                        const OdometryChain& chain,
                                        const std::set<int>& keyframes,
                                        const std::vector<SensorGraph>& sensors,
                                        const FilledBridges& filled);

}  // namespace nightmap
