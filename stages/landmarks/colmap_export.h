// SPDX-License-Identifier: Apache-2.0
// The landmark map as a COLMAP model.
#pragma once

#include "pipeline/io/colmap_io.h"
#include "stages/landmarks/landmarks.h"

namespace nightmap {

// Images are the map's keyframes with all their features as keypoints, in the picture as it is and
// in the order of the features artifact; the same index names a keypoint in the database. Points
// are the landmarks, in order, that at least two keyframes see: COLMAP refuses to adjust a point
// with one observation, whose error would say nothing, since its own depth put it there. An error
// is taken in the picture, distortion included. An observation that the camera cannot have where
// the landmark came to lie (behind it, or where its distortion turns back) is no part of the track.
ColmapModel MakeColmapModel(const LandmarksInput& input, const LandmarkMap& map);

}  // namespace nightmap
