// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/landmarks_report.h"

#include <fmt/format.h>

namespace nightmap {

nlohmann::json SummarizeLandmarks(const LandmarksFigures& figures) {
  return {{"num_observers", figures.num_observers},
          {"num_regions", figures.num_regions},
          {"num_landmarks_found", figures.num_found},
          {"num_dropped_by_max_landmarks", figures.NumDropped()},
          {"num_landmarks", figures.num_landmarks},
          {"num_descriptors", figures.num_descriptors},
          {"num_observations", figures.num_observations}};
}

std::string DroppedLandmarks(const LandmarksFigures& figures) {
  if (figures.NumDropped() == 0) return "";
  return fmt::format(
      "max_landmarks drops {} of the {} landmarks found, of every keyframe those seen least; raise "
      "it in configs/sites/<site>/landmarks.toml to keep them",
      figures.NumDropped(),
      figures.num_found);
}

}  // namespace nightmap
