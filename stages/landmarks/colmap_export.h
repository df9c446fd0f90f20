// SPDX-License-Identifier: Apache-2.0
// The landmark map as a COLMAP model.
#pragma once

#include "pipeline/io/colmap_io.h"
#include "stages/landmarks/landmarks.h"

namespace nightmap {

// Images are the map's keyframes with all their features as keypoints, in the picture as it is and
// in the order of the features artifact; the same index names a keypoint in the database. Points
// are the landmarks, in order. An error is taken in the picture, distortion included. An
// observation that the camera cannot see where the landmark came to lie (behind it, or where its
// distortion turns back) is no part of the track.
ColmapModel MakeColmapModel(const LandmarksInput& input, const LandmarkMap& map);

}  // namespace nightmap
