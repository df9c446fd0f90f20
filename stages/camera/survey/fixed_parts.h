// SPDX-License-Identifier: Apache-2.0
// Parts that stay in place in the pictures of a moving camera: parts of the robot, black borders.
#pragma once

#include <cstddef>
#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

struct FixedParts {
  std::size_t num_views = 0;  // pictures that show a view of their own
  GrayImage mask;             // 255 where every view shows the same; no pixels where none is found
};

// `pictures`: gray, reduced to about 320 pixels of width, of one size, in any order. Pictures that
// show the view of another one count once, so that a camera at rest fixes nothing. Fixed are pixels
// whose gradient has one direction in most views, and those between them whose gray level hardly
// varies; what is evenly bright in every view without an edge that stays around it (a ceiling, say)
// is not. Nothing is found in fewer than kMinViews views, nor when more than kMaxFixedShare of the
// picture stays, as of a camera that does not move. Deterministic.
// After the mean of unit gradients of Mardia and Jupp, Directional Statistics, Wiley 2000.
constexpr std::size_t kMinViews = 20;
constexpr double kMaxFixedShare = 0.6;
FixedParts FindFixedParts(const std::vector<GrayImage>& pictures);

// The mask at the size of the camera's pictures, grown by `margin_px` of the mask's pixels, because
// edges of parts are blurred and the parts shake.
GrayImage EnlargeMask(const GrayImage& mask, int width, int height, int margin_px);

}  // namespace nightmap
