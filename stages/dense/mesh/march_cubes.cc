// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/mesh/march_cubes.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "stages/dense/mesh/cube_cases.h"

namespace nightmap {
namespace {

// Finds the corners of ascending cells.
class CornerFinder {
 public:
  explicit CornerFinder(const SampledGrid& grid) : grid_(grid) {}

  // Indices of the corners in the order of cube_cases.h; the first face is the lower one.
  std::array<std::size_t, 8> Of(std::uint64_t cell) {
    static const std::array<std::uint64_t, 4> kShifts{
        0, ShiftOf(1, 0, 0), ShiftOf(1, 1, 0), ShiftOf(0, 1, 0)};
    std::array<std::size_t, 8> corners{};
    for (std::size_t i = 0; i < 4; ++i) {
      if (!is_started_) {
        at_[i] = static_cast<std::size_t>(
            std::ranges::lower_bound(grid_.corners, cell + kShifts[i]) - grid_.corners.begin());
      }
      while (grid_.corners[at_[i]] < cell + kShifts[i]) ++at_[i];
      corners[i] = at_[i];
      corners[i + 4] = at_[i] + 1;  // the corner above follows
    }
    is_started_ = true;
    return corners;
  }

 private:
  const SampledGrid& grid_;
  std::array<std::size_t, 4> at_{};
  bool is_started_ = false;
};

// The edge of a cell, from its end with the smaller coordinates.
EdgeId EdgeOf(int edge, const std::array<std::size_t, 8>& corners) {
  constexpr std::array<EdgeId, 12> kAxes{0, 1, 0, 1, 0, 1, 0, 1, 2, 2, 2, 2};
  const auto e = static_cast<std::size_t>(edge);
  const auto [a, b] = kCubeEdges[e];
  const std::size_t first =
      std::min(corners[static_cast<std::size_t>(a)], corners[static_cast<std::size_t>(b)]);
  return 3 * first + kAxes[e];
}

void AddTriangles(const SampledGrid& grid,
                  const std::array<std::size_t, 8>& corners,
                  std::vector<EdgeTriangle>& triangles) {
  unsigned corners_behind = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double distance_m = grid.distances_m[corners[i]];
    if (std::isnan(distance_m)) return;
    corners_behind |= distance_m < 0 ? 1U << i : 0U;
  }
  const auto edges = EdgesOfTriangles(corners_behind);  // clockwise from the front
  for (std::size_t i = 0; i + 2 < edges.size(); i += 3) {
    triangles.push_back(
        {EdgeOf(edges[i], corners), EdgeOf(edges[i + 2], corners), EdgeOf(edges[i + 1], corners)});
  }
}

}  // namespace

std::vector<EdgeTriangle> MarchCubes(const SampledGrid& grid, int num_threads) {
  constexpr std::size_t kNumAtOnce = 4096;
  std::vector<std::vector<EdgeTriangle>> parts(grid.cells.size() / kNumAtOnce + 1);
  ParallelFor(parts.size(), num_threads, [&](std::size_t part) {
    CornerFinder finder(grid);
    const std::size_t end = std::min(grid.cells.size(), (part + 1) * kNumAtOnce);
    for (std::size_t i = part * kNumAtOnce; i < end; ++i) {
      AddTriangles(grid, finder.Of(grid.cells[i]), parts[part]);
    }
  });
  std::vector<EdgeTriangle> triangles;
  for (const auto& part : parts) triangles.insert(triangles.end(), part.begin(), part.end());
  return triangles;
}

}  // namespace nightmap
