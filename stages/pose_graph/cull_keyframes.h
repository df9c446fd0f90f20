// SPDX-License-Identifier: Apache-2.0
// Keyframes that add nothing: a second lap sees what the first saw.
#pragma once

#include <set>
#include <vector>

#include "stages/pose_graph/merged_tracks.h"

namespace nightmap {

// Keyframes of which at least three others see more than `max_seen_ratio` of the points, among
// those that `tracks` has, which two keyframes see (Mur-Artal and Tardos, ORB-SLAM, T-RO 2015,
// section VI-E), latest first. Frames in `needed` stay, and so does a keyframe whose neighbours in
// time would then share fewer than 30 points: it is what measures their motion. Deterministic.
std::set<int> RedundantKeyframes(const std::vector<Track>& tracks,
                                 const std::set<int>& keyframes,
                                 const std::set<int>& needed,
                                 double max_seen_ratio);

}  // namespace nightmap
