// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/ceiling_ekf_report.h"

namespace nightmap {

nlohmann::json Summarize(const CeilingEkfResult& result) {
  const CeilingMap& map = result.map;
  double nis = 0;
  int num_residuals = 0, num_misfits = 0;
  for (const CeilingFrame& frame : map.frames) {
    nis += frame.nis;
    num_residuals += frame.num_residuals;
    num_misfits += frame.num_misfits;
  }
  return {{"odometry_sensor", result.odometry_sensor},
          {"num_frames", map.frames.size()},
          {"num_frames_without_odometry", result.num_without_odometry},
          {"num_frames_with_slipping_wheels", result.num_slipped},
          {"num_frames_without_landmark", result.num_blind},
          {"num_sightings", num_residuals / 2},
          {"num_misfits", num_misfits},
          {"mean_nis_per_degree_of_freedom", num_residuals > 0 ? nis / num_residuals : 0.0},
          {"num_anchors", map.anchors.size()},
          {"num_landmarks", map.landmarks.size()},
          {"num_landmarks_added", result.counts.num_added},
          {"num_landmarks_deleted_as_inconsistent", result.counts.num_inconsistent},
          {"num_landmarks_deleted_as_weak", result.counts.num_weak},
          {"num_loops", map.loops.size()},
          {"num_searches_without_loop", result.num_searches_without_loop},
          {"wheel_heading_error_rad_per_m", result.heading_error_rad_per_m},
          {"mounting_tilt_rad", {result.mounting_tilt_rad.x(), result.mounting_tilt_rad.y()}}};
}

}  // namespace nightmap
