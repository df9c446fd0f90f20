// SPDX-License-Identifier: Apache-2.0
// The depth at keypoints.
#pragma once

#include "pipeline/camera/extract_features.h"

namespace nightmap {

// Looks up the depth at each raw keypoint, robust to holes and edges. Splits the valid depths of
// the window into surfaces at steps of more than 5 %. Takes the depth of the surface on
// which the centre (or the nearest valid pixel) lies, or 0 when the window straddles surfaces
// without a valid centre. An image without pixels gives no depths: all are 0.
void LookUpDepth(const DepthImage& depth, FrameFeatures* features);

}  // namespace nightmap
