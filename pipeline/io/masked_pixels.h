// SPDX-License-Identifier: Apache-2.0
// Takes what may move by itself (people, say), and what moves with the camera, out of a frame's
// pixels, before anything is made of them. A mask is not 0 where such a thing is; it has the size
// of the picture.
#pragma once

#include "pipeline/io/image_io.h"

namespace nightmap {

// Whether the mask holds a keypoint's nearest pixel. An empty mask holds nothing.
bool IsMasked(const GrayImage& mask, const Eigen::Vector2d& pixel);
bool IsAnyMasked(const GrayImage& mask);

// Replaces the masked colors by a smooth continuation of those around them, without edges at which
// features would be found: averages over ever larger squares of what is not masked (the push-pull
// method: Gortler et al., The Lumigraph, SIGGRAPH 1996, section 3.5). Gray where all is masked.
// Throws DataError when the sizes differ. Deterministic.
void FadeOut(const GrayImage& mask, ColorImage* color);

// Nothing was measured where the mask is. Throws DataError when the sizes differ.
void RemoveDepth(const GrayImage& mask, DepthImage* depth);

}  // namespace nightmap
