// SPDX-License-Identifier: Apache-2.0
#include "pipeline/planar/field_pyramid.h"

#include <algorithm>

namespace nightmap {
namespace {

// out[i] = max(a[i], b[i]), which the compiler does with many bytes at once.
void MaxOf(const std::uint8_t* a, const std::uint8_t* b, std::size_t count, std::uint8_t* out) {
  for (std::size_t i = 0; i < count; ++i) out[i] = std::max(a[i], b[i]);
}

}  // namespace

FieldPyramid::FieldPyramid(const LikelihoodField& field, int num_levels) : field_(&field) {
  levels_.push_back(FirstLevel(field));
  while (NumLevels() < num_levels) levels_.push_back(NextLevel(levels_.back()));
}

FieldPyramid::Level FieldPyramid::FirstLevel(const LikelihoodField& field) {
  Level level{0, static_cast<std::size_t>(field.Size()), {}};
  level.values.resize(level.size * level.size);
  std::ranges::transform(field.Cells(), level.values.begin(), [](float value) {
    return static_cast<std::uint8_t>(255 * value + 0.5F);
  });
  return level;
}

// A square is four squares of half its side. Those that begin `step` cells before the first square
// of the level below are the new ones at the margin, where the level below has nothing.
FieldPyramid::Level FieldPyramid::NextLevel(const Level& below) {
  const std::size_t step = static_cast<std::size_t>(below.margin) + 1;
  Level level{static_cast<int>(2 * step - 1), below.size + step, {}};
  level.values.resize(level.size * level.size);
  // Of each row the largest of two squares side by side, with empty rows before and after.
  std::vector<std::uint8_t> pairs((below.size + 2 * step) * level.size);
  for (std::size_t row = 0; row < below.size; ++row) {
    const std::uint8_t* from = &below.values[row * below.size];
    std::uint8_t* to = &pairs[(row + step) * level.size];
    std::copy(from, from + below.size, to + step);
    MaxOf(to, from, below.size, to);
  }
  for (std::size_t row = 0; row < level.size; ++row) {
    MaxOf(&pairs[row * level.size],
          &pairs[(row + step) * level.size],
          level.size,
          &level.values[row * level.size]);
  }
  return level;
}

}  // namespace nightmap
