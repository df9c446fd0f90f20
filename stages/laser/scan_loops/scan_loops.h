// SPDX-License-Identifier: Apache-2.0
// scan_loops: where a robot with a laser scanner came back to a place that it had seen before.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/edges_io.h"
#include "pipeline/laser/likelihood_field.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

struct ScanLoopsOptions {
  OPTION(std::string, scan_sensor, "", "id of the sensor; empty: the only one that scans");
  OPTION(double, resolution_m, 0.05, {0.01, 1}, "cells of the likelihood field");
  OPTION(double, sigma_m, 0.06, {0.01, 1}, "standard deviation between two measurements of a wall");
  OPTION(double, max_range_m, 30, {1, 500}, "points farther away are not used");
  OPTION(double, submap_length_m, 6, {0.5, 100}, "path that a submap is made of");
  OPTION(double, query_length_m, 2, {0, 100},
         "path about a place whose scans are looked for together; a place comes every metre");
  OPTION(double, min_path_m, 10, {0, 1000},
         "a submap is older by so much path; scan_match looks back over less");
  OPTION(double, max_distance_m, 8, {0.1, 500},
         "between a place and a submap, beyond what the drift allows");
  OPTION(int, max_candidates, 4, {1, 1000}, "submaps tried for each place");
  OPTION(double, max_shift_m, 10, {0.1, 100}, "largest window, whatever the drift");
  OPTION(double, max_turn_rad, 0.8, {0.01, 3.15}, "likewise for the heading");
  OPTION(double, min_score, 0.55, {0, 1}, "mean of the likelihood field at the points of a loop");
  OPTION(double, max_second_ratio, 0.9, {0, 1},
         "no loop when another place of the window scores more than this share of the best");
  REGISTER_OPTIONS();
};

struct ScanLoopsInput {
  std::vector<Signal> scans;          // of all sensors of the site
  std::vector<StampedPose> keyscans;  // start_from_robot, by scan_match
  SensorEdges odometry;               // between consecutive keyscans, by scan_match
};

// A place that was looked for in an older submap.
struct ScanLoopCandidate {
  std::size_t submap_keyscan = 0;  // index of the keyscan in the submap's middle
  std::size_t query_keyscan = 0;
  double score = 0;         // 0: nothing found
  double second_score = 0;  // best of other places, as far as it is above max_second_ratio * score
  bool is_loop = false;
  Rigid3 query_from_submap;
  Matrix6d covariance = Matrix6d::Identity();  // of a loop
};

struct ScanLoopsResult {
  std::vector<ScanLoopCandidate> candidates;
  SensorEdges edges;  // the loops, of the robot, from the submap's keyscan to the query's
  std::size_t num_submaps = 0;
  std::size_t num_queries = 0;
};

// Cuts the drive into submaps that overlap by half. Every metre, looks for the scans of a
// short stretch in the older submaps in which the drift since then lets it be: the best pose of the
// window by branch and bound (search_pose.h; Hess, Kohler, Rapp, Andor, Real-time loop closure in
// 2D LIDAR SLAM, ICRA 2016), refined (match_scan.h). It is a loop when it scores enough, and no
// other place of the window scores nearly as much: two rooms that look alike are none. Neither is
// one that another submap casts doubt on (doubtful_loops.h). pose_graph decides which loops to
// believe. Throws UsageError when a sensor is not named but must be, and InputError when keyscans
// and edges do not fit together. Deterministic at any number of threads; memory grows with the
// keyscans' points, as the scans themselves are let go of, and one submap per thread.
ScanLoopsResult RunScanLoops(const ScanLoopsOptions& options,
                             ScanLoopsInput input,
                             Progress& progress,
                             int num_threads);

}  // namespace nightmap
