// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_adjust/ceiling_adjust_report.h"

namespace nightmap {

nlohmann::json Summarize(const CeilingAdjustResult& result) {
  const Vector5d& mounting = result.mounting;
  return {{"num_keyframes", result.num_keyframes},
          {"num_landmarks", result.map.landmarks.size()},
          {"num_sightings", result.num_sightings},
          {"num_motions_without_wheels", result.num_guessed_motions},
          {"num_iterations", result.solution.num_iterations},
          {"has_converged", result.solution.has_converged},
          {"initial_cost", result.solution.initial_cost},
          {"final_cost", result.solution.final_cost},
          {"median_error_px", result.solution.median_error_px},
          {"ceiling_height_m", result.level_m},
          {"wheel_scale_error", result.wheels.x()},
          {"wheel_heading_error_rad_per_m", result.wheels.y()},
          {"mounting_rotation_rad", {mounting[0], mounting[1], mounting[2]}},
          {"mounting_translation_m", {mounting[3], mounting[4]}}};
}

}  // namespace nightmap
