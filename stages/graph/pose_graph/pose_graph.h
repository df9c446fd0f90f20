// SPDX-License-Identifier: Apache-2.0
// pose_graph: computes one consistent trajectory of all shards from motions that sensors measured.
// The graph's frame is about that of the first keyframe; the map_frame stage makes it upright.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/graph/closed_graph_io.h"
#include "pipeline/io/edges_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/io/odometry_io.h"
#include "stages/graph/pose_graph/optimize_graph.h"
#include "stages/graph/pose_graph/sensor_calibration.h"

namespace nightmap {

// Errors of a sensor's mounting or clock that are larger than these are warned of.
struct CalibrationWarnings {
  double min_error_m = 0.02;
  double min_error_rad = 0.0175;
  double min_error_s = 0.015;
};

struct PoseGraphOptions {
  EdgeSigmaFloor edge_sigma_floor;
  OPTION_AT("edge_sigma_floor_m", edge_sigma_floor.m, {1e-5, 1},
            "added in quadrature to every edge's translation");
  OPTION_AT("edge_sigma_floor_rad", edge_sigma_floor.rad, {1e-5, 1},
            "added in quadrature to every edge's rotation");
  OPTION(double, max_drift, 10.0, {0.5, 1e9},
         "Mahalanobis distance from the odometry beyond which a loop is rejected");
  CalibrationWarnings calibration_warnings;
  OPTION_AT("sensor_min_error_m", calibration_warnings.min_error_m, {0, 100},
            "a sensor's mounting pose that is farther off is warned of");
  OPTION_AT("sensor_min_error_rad", calibration_warnings.min_error_rad, {0, 4},
            "likewise, turned by more");
  OPTION_AT("sensor_min_error_s", calibration_warnings.min_error_s, {0, 100},
            "a sensor's clock that is farther off is warned of");
  OPTION(bool, calibrate_sensors, false, "correct the edges of a sensor by what is warned of");
  OPTION(double, min_connected_ratio, 0.05, {0, 1},
         "fails when measured motion connects a smaller share of the frames; of sites with many "
         "recordings that never meet, lower it");
  REGISTER_OPTIONS();
};

// Without a camera: AdoptOdometry makes frames and odometry of the edges of another sensor.
struct PoseGraphInput {
  std::vector<FrameRecord> frames;      // all frames, contiguous from 0
  std::vector<OdometryShard> odometry;  // without their tracks
  std::vector<CountedPair> loops;       // accepted and rejected candidates
  std::vector<SensorEdges> edges;       // of other sensors; nodes are frames of the lists
};

struct LoopRecord {
  int frame_a = 0;
  int frame_b = 0;
  double score = 0;
  int num_putative = 0;
  int num_inliers = 0;
  double drift = 0;  // Mahalanobis distance from the odometry; 0 when it was not verified
  double error = 0;  // Mahalanobis distance after optimization; 0 when it never entered the graph
  bool is_accepted = false;
  std::string reason;  // empty when accepted
};

// How the edges of a sensor other than the camera agree with the result.
struct SensorRecord {
  std::string sensor;
  int num_odometry = 0;
  int num_loops = 0;
  int num_priors = 0;
  // Loops rejected as the camera's are; loops and priors at frames without a place in the odometry.
  int num_refused = 0;
  // Median over the others of the Mahalanobis distance from the trajectory; 2.3 where the
  // covariances are right and nothing else holds the trajectory.
  double median_residual = 0;
  std::optional<SensorCalibration> calibration;  // none: too little motion, or mounting unknown
  std::vector<std::string> warnings;             // of a wrong mounting pose or clock
};

// Frames connected by measured edges and accepted loops. Where there are several parts, only
// guessed motion joins them.
struct GraphPart {
  int num_frames = 0;
  std::vector<std::pair<int, int>> runs;  // first and last frame_idx, ascending
};

struct PoseGraphResult {
  ClosedGraph graph;
  std::vector<PoseEdge> edges;            // believed ones between keyframes
  std::vector<Rigid3> graph_from_camera;  // by frame
  std::vector<LoopRecord> loops;          // all candidates: the camera's, then those of sensors
  std::vector<SensorRecord> sensors;      // those of the edges
  std::vector<GraphPart> parts;           // most frames first
  bool returns_to_start = false;   // a loop joins the first tenth of the keyframes to the last
  GraduationSummary optimization;  // with the loops closed
};

// Chains the shards, drops loops that contradict the odometry and closes the others (graduated
// non-convexity decides which to accept). Edges of other sensors fill what the camera lost and
// enter the graph. Frames move along with the keyframes around them. Deterministic; one thread.
// Throws ThresholdError when measured motion connects less than min_connected_ratio of the frames:
// there is no map then.
PoseGraphResult RunPoseGraph(const PoseGraphOptions& options,
                             const PoseGraphInput& input,
                             Progress& progress);

}  // namespace nightmap
