// SPDX-License-Identifier: Apache-2.0
// Keyframes that see the triangles of a mesh.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "pipeline/dense/mesh_io.h"
#include "pipeline/dense/rgbd_keyframes.h"

namespace nightmap {

constexpr std::uint32_t kNoView = std::numeric_limits<std::uint32_t>::max();

// A keyframe that sees a triangle. Scores are positive.
struct TriangleView {
  std::uint32_t view = kNoView;  // index in the source's keyframes
  float score = 0;
};

// The best views of a triangle, best first, then without a view. Equal ones in order of keyframes.
constexpr std::size_t kMaxViews = 8;
using BestViews = std::array<TriangleView, kMaxViews>;

struct FoundViews {
  std::vector<BestViews> of_triangles;
  std::vector<std::string> skipped;  // why keyframes were left out
};

// A keyframe sees a triangle from its front, up to max_range_m of the source's region, if its depth
// at the corners and the centre is that of the triangle, within three sigma of its noise and half
// of the triangle's longest edge, and nothing nearer is measured at these pixels or beside them.
// Where only the depth of the centre is that of the triangle, and what the others see is behind it,
// the view comes after all others: so it is at the end of a surface. The score of a view grows with
// the area of the triangle in the picture, up to texels of texel_m.
FoundViews FindViews(const TileMesh& mesh,
                     const KeyframeSource& source,
                     double texel_m,
                     Progress& progress,
                     int num_threads);

}  // namespace nightmap
