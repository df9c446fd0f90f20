// SPDX-License-Identifier: Apache-2.0
// Plans a robot's path over the occupancy grid, from a point, a located query, an object or a thing
// to one or more others.
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
#include "pipeline/io/things_io.h"
#include "pipeline/plan/floors_io.h"
#include "pipeline/plan/footprint.h"
#include "pipeline/plan/objects_io.h"
#include "stages/plan/plan/cost_map.h"
#include "stages/plan/plan/endpoints.h"
#include "stages/plan/plan/narrow_places.h"

namespace nightmap {

struct PlanOptions {
  OPTION(std::string, start, "",
         "\"x_m,y_m\" or \"x_m,y_m,z_m\" in the map, \"picture:NAME\", \"scan:NAME\", "
         "\"object:NAME\" of an object or a thing of the map, or \"\": first located query");
  OPTION(std::string, goal, "",
         "likewise, or \"object:CLASS\": the thing of a class with the shortest way; several "
         "goals, separated by \";\", are visited in order; \"\": last located query");
  OPTION(int, floor, 0, {-1000, 1000},
         "floor of ends without a z: 0 is the one at z = 0, 1 the next above, -1 the next below");
  OPTION(std::string, planner, "any_angle", {"any_angle", "astar"},
         "straight lines in any direction (Lazy Theta*), or steps from cell to cell (A*)");
  OPTIONS_OF(FootprintOptions, footprint);
  OPTIONS_OF(CostOptions, cost);
  OPTION(double, snap_radius_m, 1, {0.0, 10.0},
         "how far an end may be moved to a place where the robot can stand, from an object or a "
         "thing as measured from its rectangle; 0: not at all");
  OPTION(bool, shorten, true,
         "pulls the path tight: moves it to the cheapest places nearby and straightens it where "
         "possible");
  REGISTER_OPTIONS();
};

struct PlanInputs {
  OccupancyGrid grid;
  std::vector<QueryResult> queries;
  // map_from_camera, or of a robot that scans; gives default ends when nothing is located.
  std::vector<StampedPose> trajectory;
  std::vector<FloorFiles> floors = {FloorFiles{}};
  std::size_t floor_idx = 0;  // index of the grid's floor, from PlanFloor
  std::vector<MapObject> objects = {};
  std::vector<Thing> things = {};
};

// Part of the path from one end to the next.
struct PlanLeg {
  std::size_t first_point = 0;  // index in the path
  std::size_t last_point = 0;   // also the next leg's first point
  double length_m = 0;
  double min_clearance_m = 0;    // least clearance of the cells that it touches
  double search_cost_m = 0;      // length of the search's path, weighted by nearness to obstacles
  std::size_t num_vertices = 0;  // number of vertices of the search's path
  std::size_t num_expanded = 0;
};

struct PlanResult {
  FloorFiles floor;
  std::vector<Endpoint> ends;   // the start and every goal
  std::vector<PlanLeg> legs;    // one fewer than the ends
  std::vector<PathPoint> path;  // at most one cell apart
  std::vector<NarrowPlace> narrow_places;
  std::size_t num_hole_cells = 0;  // unknown cells of the floor that count as free
};

// Index in `inputs.floors` of the floor to plan on; needs no grid. Throws as MakeRequests and
// ChooseFloor do.
std::size_t PlanFloor(const PlanOptions& options, const PlanInputs& inputs);

// The start and every goal as asked for, on the floor of the grid. Throws as MakeRequests does.
std::vector<EndChoices> RequestsOnFloor(const PlanOptions& options, const PlanInputs& inputs);

// Searches a path from cell to cell (A*) or of straight lines (Lazy Theta*) over the inflated grid,
// whose small holes count as free, then pulls it tight (Tighten). The robot's circle touches no
// obstacle anywhere on the path; a final check ensures that. Deterministic. Throws UsageError on
// malformed ends or footprints, DataError on ends that are not usable or when no path joins them.
PlanResult RunPlan(const PlanOptions& options,
                   const PlanInputs& inputs,
                   Progress& progress,
                   int num_threads);

}  // namespace nightmap
