// SPDX-License-Identifier: Apache-2.0
// Landmarks of one region.
#pragma once

#include <vector>

#include "pipeline/camera/region_tracks.h"
#include "stages/camera/landmarks/landmark_of_track.h"

namespace nightmap {

// The landmarks that lie in the region's box. Regions take features in their order: two landmarks
// of different regions never share one. A landmark that lost half of its observations or more is
// one of the earlier region, seen again, and is dropped.
std::vector<Landmark> FinishRegion(const LandmarksOptions& options,
                                   DescriptorKind kind,
                                   const Rectangle& box,
                                   const RegionTracks& tracks,
                                   int num_threads,
                                   TakenFeatures* taken);

}  // namespace nightmap
