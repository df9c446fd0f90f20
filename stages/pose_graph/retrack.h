// SPDX-License-Identifier: Apache-2.0
// Tracks made anew once the poses are good.
#pragma once

#include <map>
#include <vector>

#include "pipeline/features/landmark_tracker.h"
#include "stages/pose_graph/merged_tracks.h"
#include "stages/pose_graph/pose_graph.h"

namespace nightmap {

// Points that any of the frames see, found by projection: a feature near a projected point, at its
// depth and of similar looks, shows it, whatever lies between the two in time. Odometry's tracks
// end where the point leaves the picture, and loops join few of them again (the fusing of points in
// Mur-Artal and Tardos, T-RO 2015 and 2017). Of points seen once nothing is kept.
std::vector<Track> Retrack(const PoseGraphInput& input,
                           const std::map<int, Rigid3>& graph_from_frame,
                           const LandmarkTrackerOptions& options);

}  // namespace nightmap
