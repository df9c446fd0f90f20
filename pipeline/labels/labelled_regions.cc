// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/labelled_regions.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace nightmap {
namespace {

constexpr float kMaxDepthStep = 0.1F;

bool LeadsTo(float from_m, float to_m) {
  if (from_m <= 0 || to_m <= 0) return to_m <= 0;
  return std::abs(from_m - to_m) < kMaxDepthStep * std::min(from_m, to_m);
}

}  // namespace

LabelledRegions FindLabelledRegions(const GrayImage& may_move, const DepthImage& depth) {
  LabelledRegions regions{{may_move.width, may_move.height, 1, {}}, 0};
  regions.of_pixel.pixels.resize(may_move.pixels.size());
  std::vector<std::pair<int, int>> open;
  const auto enter = [&](int x, int y) {
    regions.of_pixel.At(x, y) = regions.num;
    open.emplace_back(x, y);
  };
  for (int first_y = 0; first_y < may_move.height; ++first_y) {
    for (int first_x = 0; first_x < may_move.width; ++first_x) {
      if (may_move.At(first_x, first_y) == 0 || regions.of_pixel.At(first_x, first_y) != 0)
        continue;
      ++regions.num;
      enter(first_x, first_y);
      while (!open.empty()) {
        const auto [x, y] = open.back();
        open.pop_back();
        for (const auto& [to_x, to_y] : {std::pair{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}}) {
          if (to_x < 0 || to_y < 0 || to_x >= may_move.width || to_y >= may_move.height) continue;
          if (may_move.At(to_x, to_y) == 0 || regions.of_pixel.At(to_x, to_y) != 0) continue;
          if (LeadsTo(depth.At(x, y), depth.At(to_x, to_y))) {
            enter(to_x, to_y);
          }
        }
      }
    }
  }
  return regions;
}

}  // namespace nightmap
