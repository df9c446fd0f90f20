// SPDX-License-Identifier: Apache-2.0
// Finds keyframes that add nothing, such as those of a second lap.
#pragma once

#include <set>

#include "stages/camera/adjust/track_list.h"

namespace nightmap {

// Redundant keyframes, latest first: at least three others see more than `max_seen_ratio` of a
// redundant keyframe's points (Mur-Artal and Tardos, ORB-SLAM, T-RO 2015, section VI-E). Counts
// only points of `tracks` that two keyframes see. Frames in `needed` stay. So does a keyframe whose
// neighbours in time would otherwise share fewer than 30 points, because it measures their motion.
// Deterministic.
std::set<int> RedundantKeyframes(const TrackList& tracks,
                                 const std::set<int>& keyframes,
                                 const std::set<int>& needed,
                                 double max_seen_ratio);

}  // namespace nightmap
