// SPDX-License-Identifier: Apache-2.0
// Poses at which a submap shows objects of the map where they are, and the candidates that agree
// with one (publication CN110307838A, S102, S103 and S105).
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid2.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/planar/objects_io.h"
#include "pipeline/planar/scan_queries_io.h"
#include "stages/scan_localize/template_search.h"

namespace nightmap {

struct ObjectFilterOptions {
  double object_distance_m = 10;
  double object_margin_m = 0.2;
  double voxel_m = 0.05;
  double start_step_m = 0.5;
  int num_headings = 36;
  int num_starts = 5;
  double max_pair_distance_m = 0.5;
  double tolerance_m = 0.1;
  double min_overlap = 0.8;
  double filter_distance_m = 0.5;
  double filter_angle_deg = 10;

  void Register(OptionList& list);
};

// The second list of poses, map_from_query. Empty without a rough position, or when no object has
// its centre nearer to it than object_distance_m. Otherwise the cloud of the submap is matched to
// the walls of each such object by iterative closest points, from the poses within the rough
// position at which they come nearest to each other. A match counts when it converged, lies within
// the rough position, and the cloud covers min_overlap of the object's walls. Deterministic.
std::vector<Rigid2> PosesByObjects(const ObjectFilterOptions& options,
                                   const OccupancyGrid& grid,
                                   const std::vector<MapObject>& objects,
                                   const ScanQuery& query,
                                   const std::vector<Eigen::Vector2d>& points_in_query);

// Drops the matches that are farther than filter_distance_m or filter_angle_deg from all poses. If
// there are no poses, all stay.
std::vector<TemplateMatch> FilterByPoses(const ObjectFilterOptions& options,
                                         const std::vector<Rigid2>& poses,
                                         std::vector<TemplateMatch> matches);

}  // namespace nightmap
