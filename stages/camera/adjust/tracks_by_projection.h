// SPDX-License-Identifier: Apache-2.0
// Finds tracks anew once the poses are good.
#pragma once

#include <map>

#include "pipeline/camera/landmark_tracker.h"
#include "stages/camera/adjust/adjust.h"
#include "stages/camera/adjust/track_list.h"

namespace nightmap {

// Points that any of the frames see, found by projection: a feature observes a point if it is near
// the projection, at the point's depth and similar in appearance, however much time passed in
// between. Odometry's tracks end where the point leaves the picture, and loops join few of them
// again (compare the point fusion of Mur-Artal and Tardos, T-RO 2015 and 2017). Drops points seen
// only once. Regions of the site are searched one by one (pipeline/camera/region_tracks.h). The
// same at any number of threads.
TrackList TracksByProjection(const AdjustInput& input,
                             const std::map<int, Rigid3>& graph_from_frame,
                             const LandmarkTrackerOptions& options,
                             int num_threads);

}  // namespace nightmap
