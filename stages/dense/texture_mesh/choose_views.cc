// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/texture_mesh/choose_views.h"

#include <algorithm>
#include <functional>
#include <tuple>

#include "pipeline/base/union_find.h"

namespace nightmap {
namespace {

constexpr float kAsGood = 0.5F;
constexpr int kNumRounds = 4;

bool IsAsGood(const BestViews& views, const TriangleView& view) {
  return view.view != kNoView && view.score >= kAsGood * views[0].score;
}

bool IsAsGood(const BestViews& views, std::uint32_t view) {
  return std::ranges::any_of(
      views, [&](const TriangleView& one) { return one.view == view && IsAsGood(views, one); });
}

// The triangles for which each view is as good.
std::vector<std::vector<std::uint32_t>> TrianglesOfViews(const std::vector<BestViews>& found) {
  std::vector<std::vector<std::uint32_t>> triangles;
  for (std::uint32_t i = 0; i < found.size(); ++i) {
    for (const TriangleView& view : found[i]) {
      if (!IsAsGood(found[i], view)) continue;
      if (view.view >= triangles.size()) triangles.resize(view.view + 1);
      triangles[view.view].push_back(i);
    }
  }
  return triangles;
}

std::vector<std::uint32_t> Cover(const std::vector<BestViews>& found) {
  const auto triangles = TrianglesOfViews(found);
  std::vector<std::size_t> num_open;
  for (const auto& some : triangles) num_open.push_back(some.size());
  std::vector<std::uint32_t> views(found.size(), kNoView);
  while (!num_open.empty()) {
    const auto most = std::ranges::max_element(num_open);
    if (*most == 0) break;
    const auto view = static_cast<std::uint32_t>(most - num_open.begin());
    for (const std::uint32_t triangle : triangles[view]) {
      if (views[triangle] != kNoView) continue;
      views[triangle] = view;
      for (const TriangleView& other : found[triangle]) {
        if (IsAsGood(found[triangle], other)) --num_open[other.view];
      }
    }
  }
  return views;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> NeighborsOf(const std::vector<Triangle>& triangles) {
  struct Side {
    std::uint32_t low, high, triangle;
    std::size_t side;
    bool operator<(const Side& other) const {
      return std::tie(low, high, triangle, side) <
             std::tie(other.low, other.high, other.triangle, other.side);
    }
  };
  std::vector<Side> sides;
  std::vector<std::array<std::uint32_t, 3>> neighbors(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    neighbors[i] = {i, i, i};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax({triangles[i][k], triangles[i][(k + 1) % 3]});
      sides.push_back({low, high, i, k});
    }
  }
  std::ranges::sort(sides, std::less<>());
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const Side &a = sides[i], &b = sides[i + 1];
    if (a.low != b.low || a.high != b.high) continue;
    neighbors[a.triangle][a.side] = b.triangle;
    neighbors[b.triangle][b.side] = a.triangle;
    ++i;
  }
  return neighbors;
}

std::vector<std::uint32_t> ChooseViews(const std::vector<BestViews>& found,
                                       const std::vector<std::array<std::uint32_t, 3>>& neighbors) {
  std::vector<std::uint32_t> views = Cover(found);
  for (int round = 0; round < kNumRounds; ++round) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      const auto& [a, b, c] = neighbors[i];
      const std::uint32_t most = views[b] == views[c] && b != i ? views[b] : views[a];
      const int num_most = (a != i && views[a] == most) + (b != i && views[b] == most) +
                           (c != i && views[c] == most);
      if (num_most >= 2 && most != kNoView && IsAsGood(found[i], most)) views[i] = most;
    }
  }
  return views;
}

std::vector<ViewChart> ChartsOf(const std::vector<std::uint32_t>& views,
                                const std::vector<std::array<std::uint32_t, 3>>& neighbors) {
  UnionFind sets(views.size());
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const std::uint32_t other : neighbors[i]) {
      if (views[other] == views[i]) sets.Join(i, other);
    }
  }
  std::vector<std::size_t> chart_of(views.size());
  std::vector<ViewChart> charts;
  for (std::uint32_t i = 0; i < views.size(); ++i) {
    const std::size_t first = sets.Find(i);
    if (first == i) {
      chart_of[i] = charts.size();
      charts.push_back({views[i], {}});
    }
    charts[chart_of[first]].triangles.push_back(i);
  }
  return charts;
}

}  // namespace nightmap
