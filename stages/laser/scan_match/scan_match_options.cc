// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_match/scan_match.h"

namespace nightmap {

void ScanMatchOptions::Register(OptionList& list) {
  list.Add("scan_sensor", &scan_sensor, "id of the sensor; empty: the only one that scans");
  list.Add("odometry_sensor",
           &odometry_sensor,
           "id of the wheels' odometry; empty: the only one of the site; none: without");
  list.Add("resolution_m", &field.resolution_m, Range(0.01, 1), "cells of the likelihood field");
  list.Add("half_extent_m",
           &field.half_extent_m,
           Range(1, 500),
           "of the field around the first scan of a submap");
  list.Add("sigma_m",
           &field.sigma_m,
           Range(0.01, 1),
           "standard deviation between two measurements of a wall");
  list.Add("max_range_m", &max_range_m, Range(1, 500), "points farther away are not used");
  list.Add("keyscan_distance_m",
           &keyscan_distance_m,
           Range(0, 100),
           "a scan enters the submap after such a way");
  list.Add("keyscan_angle_rad", &keyscan_angle_rad, Range(0, 7), "... or after such a turn");
  list.Add("submap_keyscans", &submap_keyscans, Range(2, 10000), "keyscans of a submap");
  list.Add("min_points", &min_points, Range(3, 100000), "a scan with fewer points is not matched");
  list.Add("min_score",
           &min_score,
           Range(0, 1),
           "a scan that fits worse keeps its prediction; 1: each point on an earlier one");
  wheels.Register(list);
  list.Add("walking_sigma_m_per_s",
           &walking_sigma_m_per_s,
           Range(0.001, 100),
           "deviation from the last motion, without odometry");
  list.Add("walking_sigma_rad_per_s", &walking_sigma_rad_per_s, Range(0.001, 100), "likewise");
  list.Add("max_failed_ratio",
           &max_failed_ratio,
           Range(0, 1),
           "fails when a larger share of the scans does not fit");
}

}  // namespace nightmap
