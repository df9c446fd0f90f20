// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/field_pyramid.h"

#include <algorithm>
#include <cmath>

namespace nightmap {
namespace {

// out[i] = max(a[i], b[i]), which the compiler does with many bytes at once.
void MaxOf(const std::uint8_t* a, const std::uint8_t* b, std::size_t count, std::uint8_t* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = std::max(a[i], b[i]);
}

}  // namespace

FieldPyramid::FieldPyramid(const LikelihoodField& field, int num_levels) : field_(&field) {
  levels_.push_back(FirstLevel(field));
  for (std::size_t step = 1; NumLevels() < num_levels; step *= 2) {
    levels_.push_back(NextLevel(levels_.back(), step));
  }
}

FieldPyramid::Level FieldPyramid::FirstLevel(const LikelihoodField& field) {
  const CellBox& box = field.Box();
  const Eigen::Array2i size = (box.end - box.first).array().max(0);
  Level level{
      box.first, static_cast<std::size_t>(size.x()), static_cast<std::size_t>(size.y()), {}};
  level.values.reserve(level.columns * level.rows);
  for (int row = box.first.y(); row < box.end.y(); ++row) {
    for (int column = box.first.x(); column < box.end.x(); ++column) {
      level.values.push_back(
          static_cast<std::uint8_t>(std::nearbyint(255 * field.At(column, row))));
    }
  }
  return level;
}

// A square is four squares of half its side. The first ones begin `step` cells before those of the
// level below.
FieldPyramid::Level FieldPyramid::NextLevel(const Level& below, std::size_t step) {
  const int before = static_cast<int>(step);
  Level level{
      below.first - Eigen::Vector2i(before, before), below.columns + step, below.rows + step, {}};
  level.values.resize(level.columns * level.rows);
  // A pair is the larger of two squares side by side. Empty rows stand before and after.
  std::vector<std::uint8_t> pairs((below.rows + 2 * step) * level.columns);
  for (std::size_t row = 0; row < below.rows; ++row) {
    const std::uint8_t* from = &below.values[row * below.columns];
    std::uint8_t* to = &pairs[(row + step) * level.columns];
    std::copy(from, from + below.columns, to + step);
    MaxOf(to, from, below.columns, to);
  }
  for (std::size_t row = 0; row < level.rows; ++row) {
    MaxOf(&pairs[row * level.columns],
          &pairs[(row + step) * level.columns],
          level.columns,
          &level.values[row * level.columns]);
  }
  return level;
}

}  // namespace nightmap
