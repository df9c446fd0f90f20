// SPDX-License-Identifier: Apache-2.0
// wheel_edges: turns the odometry of the wheels into edges between frames, for pose_graph.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/recording/wheel_edges.h"

namespace nightmap {

struct WheelEdgesOptions {
  OPTION(std::string, sensor, "", "id of the sensor; empty: the only one that measures odometry");
  OPTIONS_OF(WheelNoise, noise);
  REGISTER_OPTIONS();
};

struct WheelEdgesInput {
  std::vector<FrameRecord> frames;  // of all shards
  std::vector<RgbdCamera> cameras;
  std::vector<Signal> odometry;  // of every sensor that measures it
};

struct WheelEdgesResult {
  SensorEdges edges;
  int num_motions = 0;  // of consecutive frames of a sequence; those without an edge included
};

// Edges of the chosen sensor as WheelEdges makes them. Warns of a camera with the axes of the
// wheels. Throws UsageError when `sensor` names none, or none while there are several, and
// InputError naming the remedy when there is no odometry or no edge. Deterministic.
WheelEdgesResult RunWheelEdges(const WheelEdgesOptions& options, const WheelEdgesInput& input);

}  // namespace nightmap
