// SPDX-License-Identifier: Apache-2.0
// Poses at which a submap shows objects of the map where they are, and the candidates that agree
// with one (publication CN110307838A, S102, S103 and S105).
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid2.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/laser/scan_queries_io.h"
#include "pipeline/plan/objects_io.h"
#include "stages/laser/scan_localize/template_search.h"

namespace nightmap {

struct ObjectFilterOptions {
  OPTION(double, object_distance_m, 10, {0, 1000},
         "objects as near as this to the rough position are looked for in the submap");
  double object_margin_m = 0.2;  // walls so far outside of an object's rectangle belong to it
  OPTION(double, voxel_m, 0.05, {0.01, 1}, "of the filter of the submap's cloud");
  double start_step_m = 0.5;         // between the places that the matching of objects may start at
  int num_headings = 36;             // that the matching may start with
  int num_starts = 5;                // per object: the nearest
  double max_pair_distance_m = 0.5;  // points farther apart are no pair
  OPTION(double, min_overlap, 0.5, {0, 1},
         "share of the walls of an object in sight that beams end on where it is seen");
  OPTION(double, filter_distance_m, 0.5, {0.01, 100},
         "candidates farther from all poses by objects are dropped");
  OPTION(double, filter_angle_deg, 10, {0.1, 180},
         "candidates turned more from all poses by objects are dropped");
  REGISTER_OPTIONS();
};

// Scene in which the objects are looked for.
struct ObjectScene {
  const OccupancyGrid& grid;
  const ScanQuery& query;
  double max_range_m;  // of the points of the query that are used
};

// An object whose centre is nearer to the rough position than object_distance_m, and its walls.
struct NearObject {
  std::size_t object_idx = 0;
  std::vector<Eigen::Vector2d> walls_in_map;
};

// None without a rough position. Objects with too few walls to have a shape are left out.
std::vector<NearObject> ObjectsNear(const ObjectFilterOptions& options,
                                    const ObjectScene& scene,
                                    const std::vector<MapObject>& objects);

// A pose at which an object is where the map has it.
struct ObjectPose {
  std::size_t object_idx = 0;
  Rigid2 map_from_query;
  int num_in_sight = 0;  // walls of the object that the scan tells of, from this pose
  double overlap = 0;    // the share of them that beams end on
};

// The second list of poses, object after object. The cloud
// of the submap is matched to the walls of each object by iterative closest points, from the poses
// within the rough position at which cloud and walls come nearest to each other, and from the
// matches of the template that see the object. The latter count as they are, too, because a few
// points of a straight wall let the matching slide along it. A pose is listed when it lies within
// the rough position, and the beams end on min_overlap of the walls that are in sight from there
// (ViewInSight). A wall that beams pass through is not covered; one that beams end before is
// not counted, since people and furniture hide objects, nor is one whose beam did not come back.
// Deterministic.
std::vector<ObjectPose> PosesByObjects(const ObjectFilterOptions& options,
                                       const ObjectScene& scene,
                                       const std::vector<NearObject>& objects,
                                       const std::vector<TemplateMatch>& matches);

// The best poses of each object, object after object, no two of an object at the same place.
std::vector<ObjectPose> PosesApart(std::vector<ObjectPose> poses);

// Drops the matches from which an object would be in sight, and that are farther than
// filter_distance_m or filter_angle_deg from all poses. If there are no poses, all stay.
std::vector<TemplateMatch> FilterByPoses(const ObjectFilterOptions& options,
                                         const ObjectScene& scene,
                                         const std::vector<NearObject>& objects,
                                         const std::vector<ObjectPose>& poses,
                                         std::vector<TemplateMatch> matches);

}  // namespace nightmap
