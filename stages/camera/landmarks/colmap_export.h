// SPDX-License-Identifier: Apache-2.0
// Exports the landmark map as a COLMAP model.
#pragma once

#include "pipeline/io/colmap_io.h"
#include "stages/camera/landmarks/landmarks.h"

namespace nightmap {

// Images are the map's keyframes with all their features as keypoints, distorted as in the picture
// and in the order of the features artifact; the same index names a keypoint in the database.
// Points are the landmarks, in order, that at least two keyframes see. COLMAP refuses to adjust a
// point with one observation; the error of such a point means nothing, since its own depth placed
// it. Errors are measured in the distorted picture. The track leaves out observations that the
// camera cannot have of the landmark's final position (behind the camera, or where its distortion
// turns back).
ColmapModel MakeColmapModel(const LandmarksInput& input, const LandmarkMap& map);

}  // namespace nightmap
