// SPDX-License-Identifier: Apache-2.0
// Matches restricted to a place: what some keyframes see together.
#pragma once

#include <vector>

#include "pipeline/geometry/camera.h"
#include "stages/localize/landmark_index.h"
#include "stages/localize/localize.h"

namespace nightmap {

// The matches whose landmarks hang together, the largest such group: two landmarks do when a
// keyframe sees both. Wrong matches are strewn over the map and mostly alone (Sattler, Leibe,
// Kobbelt, ECCV 2012, section 4).
std::vector<LandmarkMatch> LargestPlace(const LandmarkIndex& index,
                                        const std::vector<LandmarkMatch>& matches);

// The keyframes that look most alike by their words, parted by covisibility; for each part, all
// features against all its landmarks. Best part first.
std::vector<std::vector<LandmarkMatch>> SearchByRetrieval(const LocalizeOptions& options,
                                                          const LandmarkIndex& index,
                                                          const FrameFeatures& features);

// The same features somewhere else: of each match's feature the most similar landmark of its word
// that is at least rival_distance_m away from the match's own; of these what one keyframe sees, the
// one that sees most.
std::vector<LandmarkMatch> SearchRivals(const LocalizeOptions& options,
                                        const LandmarkIndex& index,
                                        const FrameFeatures& features,
                                        const std::vector<LandmarkMatch>& matches);

// The landmarks of the keyframes that see most of `seen`, projected with a first pose; each is
// matched within guided_radius_px.
std::vector<LandmarkMatch> SearchByPose(const LocalizeOptions& options,
                                        const LandmarkIndex& index,
                                        const FrameFeatures& features,
                                        const Camera& camera,
                                        const Rigid3& camera_from_map,
                                        const std::vector<int>& seen);

}  // namespace nightmap
