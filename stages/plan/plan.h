// SPDX-License-Identifier: Apache-2.0
// Plans a path for a round robot from one point or picture to another on the occupancy grid.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/queries_io.h"
#include "stages/plan/cost_map.h"
#include "stages/plan/endpoints.h"

namespace nightmap {

struct PlanOptions {
  std::string start;  // "x_m,y_m", "picture:NAME", or empty: the first located query
  std::string goal;   // the same; empty: the last located query
  RobotOptions robot;
  double snap_radius_m = 0.5;
  bool shorten = true;

  void Register(OptionList& list);
};

struct PlanInputs {
  OccupancyGrid grid;
  std::vector<QueryResult> queries;
  std::vector<StampedPose> trajectory;  // map_from_camera; for default ends when nothing is located
};

struct PathPoint {
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  double heading_rad = 0;  // counter-clockwise from x; of the way onwards, the last as before
  double distance_m = 0;   // along the path
};

struct PlanResult {
  Endpoint start;
  Endpoint goal;
  std::vector<PathPoint> path;  // at most one cell apart
  double length_m = 0;
  double min_clearance_m = 0;  // to the nearest obstacle cell, centre to centre
  std::size_t num_cells = 0;   // of the A* path
  std::size_t num_expanded = 0;
  double search_cost_m = 0;  // length weighted by nearness to obstacles
};

// A* on the inflated grid, then straight shortcuts. Every cell the path touches is free for the
// robot; this is checked at the end. Deterministic. Throws UsageError on malformed ends, DataError
// on ends that are not usable or when no path joins them.
PlanResult RunPlan(const PlanOptions& options,
                   const PlanInputs& inputs,
                   Progress& progress,
                   int num_threads);

}  // namespace nightmap
