// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/scan_adjust.h"

namespace nightmap {

void ScanAdjustOptions::Register(OptionList& list) {
  list.Add("scan_sensor", &scan_sensor, "id of the sensor; empty: the only one that scans");
  list.Add("max_range_m", &max_range_m, Range(1, 500), "points farther away are not used");
  list.Add("spacing_m", &spacing_m, Range(0.001, 1), "distance of the points used on a wall");
  list.Add("sigma_m",
           &sigma_m,
           Range(0.001, 1),
           "distance of a point from a wall beyond which it counts less and less");
  list.Add("first_gate_m",
           &first_gate_m,
           Range(0.01, 5),
           "in the first round a point matches the nearest one up to so far away");
  list.Add("last_gate_m", &last_gate_m, Range(0.01, 5), "likewise in the later rounds");
  list.Add("num_rounds", &num_rounds, Range(0, 100), "rounds of matching and solving; 0: none");
  list.Add("neighbour_distance_m",
           &neighbour_distance_m,
           Range(0.1, 50),
           "scans up to so far apart are compared; a turn of a radian counts as a metre");
  list.Add(
      "num_near_in_time",
      &num_near_in_time,
      Range(1, 20),
      "each scan is compared with so many before it: the last one, the second, fourth, eighth");
  list.Add(
      "num_of_other_times", &num_of_other_times, Range(0, 100), "and with so many of other times");
}

}  // namespace nightmap
