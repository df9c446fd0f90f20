// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/texture_mesh/pack_rectangles.h"

#include <algorithm>
#include <numeric>

namespace nightmap {
namespace {

struct Row {
  std::size_t page = 0;
  int top = 0;
  int used = 0;  // pixels of its width
};

}  // namespace

PackedRectangles PackRectangles(const std::vector<Eigen::Vector2i>& sizes, int page_px) {
  std::vector<std::size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](auto a, auto b) { return sizes[a].y() > sizes[b].y(); });
  PackedRectangles packed;
  packed.places.resize(sizes.size());
  std::vector<Row> rows;
  for (const std::size_t i : order) {
    const Eigen::Vector2i& size = sizes[i];
    if (size.isZero()) continue;
    auto row = std::ranges::find_if(
        rows, [&](const Row& some) { return some.used + size.x() <= page_px; });
    if (row == rows.end()) {
      if (packed.pages.empty() || packed.pages.back().y() + size.y() > page_px) {
        packed.pages.emplace_back(0, 0);
      }
      rows.push_back({packed.pages.size() - 1, packed.pages.back().y(), 0});
      packed.pages.back().y() += size.y();
      row = rows.end() - 1;
    }
    packed.places[i] = {row->page, {row->used, row->top}};
    row->used += size.x();
    Eigen::Vector2i& page = packed.pages[row->page];
    page.x() = std::max(page.x(), row->used);
  }
  return packed;
}

}  // namespace nightmap
