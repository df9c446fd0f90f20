// SPDX-License-Identifier: Apache-2.0
// objects: proposes object features, places of a laser map that a scan is recognized by
// (publication CN110307838A, in which a person draws them).
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/plan/objects_io.h"

namespace nightmap {

struct ObjectsOptions {
  OPTION(double, size_m, 2.4, {0.2, 20}, "diameter of a place");
  OPTION(double, min_straightness, 0.2, {0, 1},
         "a place's walls run so much along one heading or across it; clutter runs anywhere");
  OPTION(double, sigma_m, 0.06, {0.01, 1},
         "standard deviation of the distance at which a wall fits another");
  OPTION(double, min_distinctiveness, 0.25, {0, 1},
         "1 less the best score of a place anywhere else");
  OPTION(double, min_distance_m, 2, {0, 1000},
         "from the middle of a place to that of a better one");
  OPTION(int, max_objects, 20, {0, 10000}, "proposes so many, the best");
  OPTION(double, max_object_size_m, 4, {0.1, 100}, "cuts longer sides");
  REGISTER_OPTIONS();
};

struct ObjectsResult {
  std::vector<MapObject> objects;    // the most distinctive first
  std::vector<std::string> notices;  // of ClampObjects
  std::size_t num_places = 0;        // whose walls fix a pose
  std::size_t num_distinctive = 0;   // places of these that look like no other
};

// Looks at round places of the map whose walls a scan cannot slide along: corners, columns,
// alcoves. How well the occupied cells of a place fit anywhere else on the map, at any heading, is
// the best score of an exact search (search_pose.h) of the whole map's likelihood field; 1 less
// that score is the distinctiveness. Proposes the most distinctive places, none near a better one.
// An object is the box of the place's occupied cells along its walls, rounded to centimetres. The
// map does not say what stays as it is: a person should look at the proposal. Deterministic at any
// number of threads; a map turned by 90 degrees gives the same places.
ObjectsResult RunObjects(const ObjectsOptions& options,
                         const OccupancyGrid& grid,
                         Progress& progress,
                         int num_threads);

// Figures for report.json.
nlohmann::json DescribeObjects(const ObjectsResult& result);

// The map with the objects' rectangles and the numbers of their order; y up, with a scale bar.
ColorImage DrawObjects(const OccupancyGrid& grid, const std::vector<MapObject>& objects);

}  // namespace nightmap
