// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/scan_loops.h"

namespace nightmap {

void ScanLoopsOptions::Register(OptionList& list) {
  list.Add("scan_sensor", &scan_sensor, "id of the sensor; empty: the only one that scans");
  list.Add("resolution_m", &resolution_m, Range(0.01, 1), "cells of the likelihood field");
  list.Add(
      "sigma_m", &sigma_m, Range(0.01, 1), "standard deviation between two measurements of a wall");
  list.Add("max_range_m", &max_range_m, Range(1, 500), "points farther away are not used");
  list.Add("submap_length_m", &submap_length_m, Range(0.5, 100), "path that a submap is made of");
  list.Add("query_spacing_m",
           &query_spacing_m,
           Range(0.1, 100),
           "path from one place that is looked for to the next");
  list.Add("query_length_m",
           &query_length_m,
           Range(0, 100),
           "path about such a place whose scans are looked for together");
  list.Add("max_query_points",
           &max_query_points,
           Range(20, 100000),
           "of these scans so many points are used, spread evenly");
  list.Add("min_path_m",
           &min_path_m,
           Range(0, 1000),
           "a submap is older by so much path; scan_match looks back over less");
  list.Add("max_distance_m",
           &max_distance_m,
           Range(0.1, 500),
           "between a place and a submap, beyond what the drift allows");
  list.Add("max_candidates", &max_candidates, Range(1, 1000), "submaps tried for each place");
  list.Add("max_shift_m", &max_shift_m, Range(0.1, 100), "largest window, whatever the drift");
  list.Add("max_turn_rad", &max_turn_rad, Range(0.01, 3.15), "likewise for the heading");
  list.Add(
      "min_score", &min_score, Range(0, 1), "mean of the likelihood field at the points of a loop");
  list.Add("max_second_ratio",
           &max_second_ratio,
           Range(0, 1),
           "no loop when another place of the window scores more than this share of the best");
}

}  // namespace nightmap
