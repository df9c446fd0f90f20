// SPDX-License-Identifier: Apache-2.0
// scan_localize: finds where in a map laser scans were taken.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/queries_io.h"
#include "pipeline/laser/scan_queries_io.h"
#include "pipeline/plan/objects_io.h"
#include "stages/laser/scan_localize/published.h"
#include "stages/laser/scan_localize/scan_candidates.h"
#include "stages/laser/scan_localize/scan_map.h"
#include "stages/laser/scan_localize/verdict.h"

namespace nightmap {

struct ScanLocalizeOptions {
  OPTION(std::string, method, "branch_and_bound", {"branch_and_bound", "published"},
         "how places are found: all of them, or as in the publication CN110307838A");
  OPTION(double, max_object_size_m, 4, {0.1, 100},
         "longer sides of objects are cut to this, with a notice");
  OPTIONS_OF(ScanMapOptions, map);
  OPTIONS_OF(CandidateOptions, candidates);
  OPTIONS_OF(PublishedOptions, published, "published_");
  OPTIONS_OF(VerdictOptions, verdict);
  REGISTER_OPTIONS();
};

struct ScanLocalizeInput {
  OccupancyGrid grid;
  std::vector<ScanQuery> queries;
  std::vector<MapObject> objects;  // may be empty
};

// The candidates are sorted, the best first; what objects say is of the method `published` alone.
struct LocatedScan : PublishedPlaces {
  // The pose is map_from_robot; confidence is the lead of its place over the best other one: of the
  // points that only one of the two explains, those for it less those for the other. Points within
  // 0.1 m of a wall are inliers. Sigmas are in the plane.
  QueryResult result;
};

// One for each query, in their order. Looks for each scan in the whole map, or within its rough
// position, by branch and bound (Hess, Kohler, Rapp, Andor, Real-time loop closure in 2D LIDAR
// SLAM, ICRA 2016), refines all places that come near the best, and judges (Judge). With objects
// (publication CN110307838A), whose places do not change, candidates that contradict them lose. The
// method `published` finds the candidates as that publication does (published.h).
// Deterministic at any number of threads. Throws InputError of the port `grid` when the map has no
// wall.
std::vector<LocatedScan> RunScanLocalize(const ScanLocalizeOptions& options,
                                         const ScanLocalizeInput& input,
                                         Progress& progress,
                                         int num_threads);

}  // namespace nightmap
