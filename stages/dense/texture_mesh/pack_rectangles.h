// SPDX-License-Identifier: Apache-2.0
// Places rectangles on pages.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace nightmap {

struct PackedRectangle {
  std::size_t page = 0;
  Eigen::Vector2i corner = Eigen::Vector2i::Zero();  // top left, pixels
};

struct PackedRectangles {
  std::vector<PackedRectangle> places;  // of the rectangles, in their order
  std::vector<Eigen::Vector2i> pages;   // width and height, as far as used
};

// Rectangles of width x height pixels, none larger than page_px, in rows: highest first, each in
// the first row of any page with room for it. No two overlap. One of 0 x 0 needs no page.
PackedRectangles PackRectangles(const std::vector<Eigen::Vector2i>& sizes, int page_px);

}  // namespace nightmap
