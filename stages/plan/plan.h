// SPDX-License-Identifier: Apache-2.0
// Plans a path for a robot over the occupancy grid, from a point or picture to one or more others.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/floors_io.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/queries_io.h"
#include "stages/plan/cost_map.h"
#include "stages/plan/endpoints.h"
#include "stages/plan/footprint.h"

namespace nightmap {

struct PlanOptions {
  // "x_m,y_m", "x_m,y_m,z_m", "picture:NAME", or empty: the first located query
  std::string start;
  std::string goal;  // the same, several separated by ";"; empty: the last located query
  int floor = 0;     // of ends without a z
  std::string planner = "any_angle";
  FootprintOptions footprint;
  CostOptions cost;
  double snap_radius_m = 1;
  bool shorten = true;

  void Register(OptionList& list);
};

struct PlanInputs {
  OccupancyGrid grid;
  std::vector<QueryResult> queries;
  std::vector<StampedPose> trajectory;  // map_from_camera; for default ends when nothing is located
  std::vector<FloorFiles> floors = {FloorFiles{}};
  std::size_t floor_idx = 0;  // of the floor that the grid is of: PlanFloor's
};

struct PathPoint {
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  double heading_rad = 0;  // counter-clockwise from x; of the way onwards, the last as before
  double distance_m = 0;   // along the path
  int leg_idx = 0;         // of the leg that it lies on or ends
  double clearance_m = 0;  // of its cell, see CostMap
};

// From one end to the next.
struct PlanLeg {
  std::size_t first_point = 0;  // in the path, which has the end of a leg and the start of the next
  std::size_t last_point = 0;   // only once
  double length_m = 0;
  double min_clearance_m = 0;    // of the cells that it touches
  double search_cost_m = 0;      // of the search's path: length weighted by nearness to obstacles
  std::size_t num_vertices = 0;  // of the search's path
  std::size_t num_expanded = 0;
};

struct PlanResult {
  FloorFiles floor;
  std::vector<Endpoint> ends;   // the start and every goal
  std::vector<PlanLeg> legs;    // one fewer
  std::vector<PathPoint> path;  // at most one cell apart
};

// Place in `inputs.floors` of the floor to plan on, for which no grid is needed. Throws as
// MakeRequests and ChooseFloor do.
std::size_t PlanFloor(const PlanOptions& options, const PlanInputs& inputs);

// A path from cell to cell (A*) or of straight lines (Lazy Theta*) over the inflated grid, then
// pulled tight (Tighten). The robot's circle touches no obstacle anywhere on the path; this is
// checked at the end. Deterministic. Throws UsageError on malformed ends or footprints, DataError
// on ends that are not usable or when no path joins them.
PlanResult RunPlan(const PlanOptions& options,
                   const PlanInputs& inputs,
                   Progress& progress,
                   int num_threads);

}  // namespace nightmap
