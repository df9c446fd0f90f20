// SPDX-License-Identifier: Apache-2.0
// adjust: adjusts the poses of the pose graph, and the cameras, by what the pictures show. The
// graph's frame stays.
#pragma once

#include <functional>
#include <set>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/camera/landmark_tracker.h"
#include "pipeline/geometry/bundle_adjustment.h"
#include "pipeline/graph/closed_graph_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/g2o_io.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/io/odometry_io.h"
#include "pipeline/io/site_features.h"

namespace nightmap {

struct AdjustOptions {
  OPTION(double, max_seen_ratio, 0.9, {0.5, 1},
         "a keyframe is dropped when three others see a larger share of its points; 1: drops none");
  OPTION(bool, final_adjustment, true,
         "also adjusts all described frames, with points found anew by projection");
  OPTION(bool, calibrate, true,
         "estimates each camera's focal length and rolling shutter in the final adjustment");
  LandmarkTrackerOptions retrack{.max_error_px = 6.0};
  OPTION(bool, estimate_depth_scales, false,
         "estimates the depth scale of each camera relative to the first camera");
  REGISTER_OPTIONS();
};

struct AdjustInput {
  std::vector<FrameRecord> frames;  // all frames, contiguous from 0
  std::vector<RgbdCamera> cameras;
  SiteFeatures features{FeaturesShard{}};  // of these frames
  std::size_t num_shards = 0;
  std::function<OdometryShard(std::size_t)> odometry;  // of each shard, with its tracks
  std::function<std::vector<FramePair>()> loops;       // of the graph, with their matches
  ClosedGraph graph;
  std::size_t max_region_observers = 1000;  // a region whose points are found anew has no more
};

struct AdjustResult {
  PoseGraph graph;                        // keyframes that stay, and believed edges between them
  std::vector<Rigid3> graph_from_camera;  // by frame
  std::set<int> keyframes;
  double bundle_rms_px = 0;  // reprojection error after bundle adjustment
  int num_bundle_observations = 0;
  int num_culled = 0;                           // keyframes of the odometry that add nothing
  std::vector<CameraCalibration> calibrations;  // by camera; empty: nothing was adjusted
  std::vector<BundleSummary> adjustments;       // in order: of the keyframes, of described frames
  DepthOffsets depth_offsets;                   // when the final adjustment calibrates
};

// Drops redundant keyframes. Adjusts the remaining keyframes and points; then all described frames,
// with newly found points, and the cameras' focal lengths and rolling shutters. Edges of other
// sensors count no more: their agreement is in where the adjustment starts. Holds the observations
// of all points, and the features and odometry of few shards. Deterministic.
AdjustResult RunAdjust(const AdjustOptions& options,
                       const AdjustInput& input,
                       Progress& progress,
                       int num_threads);

}  // namespace nightmap
