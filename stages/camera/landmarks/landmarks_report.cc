// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/landmarks_report.h"

#include <fmt/format.h>

namespace nightmap {

nlohmann::json SummarizeLandmarks(const LandmarksResult& result) {
  std::size_t num_observations = 0;
  for (const auto& keyframes : result.map.landmark_keyframes) num_observations += keyframes.size();
  return {{"num_observers", result.map.keyframes.size()},
          {"num_landmarks_found", result.num_found},
          {"num_dropped_by_max_landmarks", result.NumDropped()},
          {"num_landmarks", result.map.NumLandmarks()},
          {"num_descriptors", result.map.NumDescriptors()},
          {"num_observations", num_observations}};
}

std::string DroppedLandmarks(const LandmarksResult& result) {
  if (result.NumDropped() == 0) return "";
  return fmt::format(
      "max_landmarks drops {} of the {} landmarks found, of every keyframe those seen least; raise "
      "it in configs/sites/<site>/landmarks.toml to keep them",
      result.NumDropped(),
      result.num_found);
}

}  // namespace nightmap
