// SPDX-License-Identifier: Apache-2.0
// Exports the landmark map as a COLMAP model.
#pragma once

#include "pipeline/io/colmap_io.h"
#include "stages/camera/landmarks/landmarks.h"

namespace nightmap {

// Cameras and images. Images are the map's keyframes with all their features as keypoints,
// distorted as in the picture and in the order of the features artifact; the same index names a
// keypoint in the database. The model reads the features of an image when a writer asks for them.
ColmapModel StartColmapModel(const LandmarksInput& input, const LandmarkMap& head);

// Adds the landmarks of a region, or of the whole map, of which at least two keyframes see each, as
// points, in order. COLMAP refuses to adjust a point with one observation; the error of such a
// point means nothing, since its own depth placed it. Errors are measured in the distorted picture.
// The track leaves out observations that the camera cannot have of the landmark's final position
// (behind the camera, or where its distortion turns back).
void AddColmapPoints(const LandmarkMap& region, ColmapModel* model);

}  // namespace nightmap
