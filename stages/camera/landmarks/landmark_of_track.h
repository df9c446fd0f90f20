// SPDX-License-Identifier: Apache-2.0
// Turns a finished track into a landmark.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/camera/landmark_tracker.h"
#include "stages/camera/landmarks/landmarks.h"

namespace nightmap {

struct Landmark {
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
  double sigma_m = 0;
  Track sightings;  // frame_idx counts the observers; only those that agree with the position
  std::vector<const std::uint8_t*> descriptors;  // of the observers' features; medoid first
};

// Returns nothing when too few observations agree or the position stays too uncertain.
std::optional<Landmark> LandmarkOfTrack(const LandmarksOptions& options,
                                        DescriptorKind kind,
                                        const std::vector<Observer>& observers,
                                        const LandmarkTrack& track);

}  // namespace nightmap
