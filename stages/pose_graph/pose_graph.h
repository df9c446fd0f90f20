// SPDX-License-Identifier: Apache-2.0
// pose_graph: computes one consistent trajectory of all shards. The graph's frame is about that of
// the first keyframe; the map_frame stage makes it upright.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/features/landmark_tracker.h"
#include "pipeline/geometry/bundle_adjustment.h"
#include "pipeline/io/edges_io.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/g2o_io.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/io/odometry_io.h"
#include "stages/pose_graph/optimize_graph.h"

namespace nightmap {

struct PoseGraphOptions {
  double edge_sigma_floor_m = 0.003;
  double edge_sigma_floor_rad = 0.002;
  double max_drift = 10.0;
  double max_loop_error = 6.0;
  double max_seen_ratio = 0.9;
  bool bundle_adjustment = true;
  int bundle_iterations = 10;
  double bundle_max_error_px = 4.0;
  bool final_adjustment = true;
  bool calibrate = true;
  LandmarkTrackerOptions retrack{.max_error_px = 6.0};
  bool estimate_depth_scales = false;
  int max_tracks_per_keyframe = 250;

  void Register(OptionList& list);
};

struct PoseGraphInput {
  std::vector<FrameRecord> frames;  // all frames, contiguous from 0
  std::vector<RgbdCamera> cameras;
  FeaturesShard features;  // of these frames
  std::vector<OdometryShard> odometry;
  std::vector<FramePair> loops;    // accepted and rejected candidates
  std::vector<SensorEdges> edges;  // of other sensors; nodes are frames of the lists
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
  // Median over the others of the Mahalanobis distance from the final trajectory; 2.3 where the
  // covariances are right and nothing else holds the trajectory.
  double median_residual = 0;
};

// Frames connected by measured edges and accepted loops. Where there are several parts, only
// guessed motion joins them.
struct GraphPart {
  int num_frames = 0;
  std::vector<std::pair<int, int>> runs;  // first and last frame_idx, ascending
};

struct PoseGraphResult {
  PoseGraph graph;                        // keyframes and accepted edges
  std::vector<Rigid3> graph_from_camera;  // by frame
  std::vector<bool> is_keyframe;          // by frame
  std::vector<LoopRecord> loops;          // all candidates
  std::vector<SensorRecord> sensors;      // those of the edges
  std::vector<GraphPart> parts;           // most frames first
  bool returns_to_start = false;  // a loop joins the first tenth of the keyframes to the last
  double bundle_rms_px = 0;       // reprojection error after bundle adjustment
  int num_bundle_observations = 0;
  int num_culled = 0;                           // keyframes of the odometry that add nothing
  std::vector<CameraCalibration> calibrations;  // by camera; empty: nothing was adjusted
  GraphSummary optimization;                    // of the graph with its loops closed
  std::vector<BundleSummary> adjustments;       // in order: of the keyframes, of described frames
};

// Chains the shards, drops loops that contradict the odometry, closes the others (graduated
// non-convexity decides which to accept) and drops redundant keyframes. Adjusts the remaining
// keyframes and points; then all described frames, with newly found points, and the cameras' focal
// lengths and rolling shutters. Edges of other sensors fill what the camera lost and enter the
// graph; the adjustment goes on from there by features alone. Deterministic.
PoseGraphResult RunPoseGraph(const PoseGraphOptions& options,
                             const PoseGraphInput& input,
                             int num_threads,
                             Progress& progress);

}  // namespace nightmap
