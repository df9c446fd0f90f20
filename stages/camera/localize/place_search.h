// SPDX-License-Identifier: Apache-2.0
// Matches restricted to one place: landmarks that keyframes see together.
#pragma once

#include <vector>

#include "pipeline/geometry/camera.h"
#include "stages/camera/localize/landmark_index.h"
#include "stages/camera/localize/localize.h"

namespace nightmap {

// The largest group of matches connected by covisibility: two landmarks are connected when a
// keyframe sees both. Wrong matches are scattered over the map and mostly isolated (Sattler, Leibe,
// Kobbelt, ECCV 2012, section 4).
std::vector<LandmarkMatch> LargestPlace(const LandmarkIndex& index,
                                        const std::vector<LandmarkMatch>& matches);

// Retrieves the keyframes most similar by words and splits them by covisibility. Matches all
// features with all landmarks of each part. Best part first.
std::vector<std::vector<LandmarkMatch>> SearchByRetrieval(const LocalizeOptions& options,
                                                          const LandmarkIndex& index,
                                                          const FrameFeatures& features);

// Matches the same features in another place. For each match, takes the most similar landmark of
// the feature's word at least rival_distance_m away from the matched one; returns those that one
// keyframe sees, for the keyframe that sees most.
std::vector<LandmarkMatch> SearchRivals(const LocalizeOptions& options,
                                        const LandmarkIndex& index,
                                        const FrameFeatures& features,
                                        const std::vector<LandmarkMatch>& matches);

// Projects the landmarks of the keyframes that see most of `seen` with a first pose, and matches
// each within guided_radius_px.
std::vector<LandmarkMatch> SearchByPose(const LocalizeOptions& options,
                                        const LandmarkIndex& index,
                                        const FrameFeatures& features,
                                        const Camera& camera,
                                        const Rigid3& camera_from_map,
                                        const std::vector<int>& seen);

}  // namespace nightmap
