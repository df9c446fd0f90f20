// SPDX-License-Identifier: Apache-2.0
// Bounds of a likelihood field over squares of cells, for branch and bound (Hess, Kohler, Rapp,
// Andor, Real-time loop closure in 2D LIDAR SLAM, ICRA 2016, section V).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/laser/likelihood_field.h"

namespace nightmap {

// Level 0 is the field in steps of 1 / 255. Level h holds the largest value of each square of 2^h x
// 2^h cells. Does not change with the field afterwards. Takes a byte per level and cell of
// the field's box.
class FieldPyramid {
 public:
  FieldPyramid(const LikelihoodField& field, int num_levels);

  int NumLevels() const { return static_cast<int>(levels_.size()); }
  const LikelihoodField& Field() const { return *field_; }
  // The largest of the cells from (column, row) on; those outside of the field are 0.
  int At(int level, int column, int row) const {
    const Level& squares = levels_[static_cast<std::size_t>(level)];
    const auto x = static_cast<std::size_t>(column - squares.first.x());
    const auto y = static_cast<std::size_t>(row - squares.first.y());
    return x < squares.columns && y < squares.rows ? squares.values[y * squares.columns + x] : 0;
  }

 private:
  struct Level {
    Eigen::Vector2i first;  // column and row of the first square
    std::size_t columns = 0;
    std::size_t rows = 0;
    std::vector<std::uint8_t> values;
  };
  static Level FirstLevel(const LikelihoodField& field);
  // `step` is the side of a square of the level below.
  static Level NextLevel(const Level& below, std::size_t step);

  const LikelihoodField* field_;
  std::vector<Level> levels_;
};

}  // namespace nightmap
