// SPDX-License-Identifier: Apache-2.0
// How well points of a scan agree with points of earlier scans: a likelihood field (Thrun, Burgard,
// Fox, Probabilistic Robotics, 2005, section 6.4), with a Gaussian around each point.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace nightmap {

struct LikelihoodFieldOptions {
  double resolution_m = 0.05;
  double half_extent_m = 40;
  double sigma_m = 0.06;  // of the distance between two measurements of one wall
};

// Cells [first, end) of columns and rows.
struct CellBox {
  Eigen::Vector2i first = Eigen::Vector2i::Zero();
  Eigen::Vector2i end = Eigen::Vector2i::Zero();
};

// A square of cells about the origin of its frame. Cell (i, j) has its centre at ((i, j) + 0.5) *
// resolution - half extent. Deterministic: the order of points does not matter.
class LikelihoodField {
 public:
  explicit LikelihoodField(const LikelihoodFieldOptions& options);

  // Points in metres in the field's frame; those outside of the square have no effect.
  void Add(const std::vector<Eigen::Vector2d>& points);

  int Size() const { return size_; }  // cells along a side
  double Resolution_m() const { return options_.resolution_m; }
  double Sigma_m() const { return options_.sigma_m; }
  // A point in units of cells: the centre of cell (i, j) is (i, j).
  Eigen::Vector2d ToCells(const Eigen::Vector2d& point) const {
    return (point.array() + options_.half_extent_m) / options_.resolution_m - 0.5;
  }
  // 1 on a point, falling to 0 away from all; 0 outside of the square.
  float At(int column, int row) const {
    return Contains(column, row) ? cells_[Index(column, row)] : 0.0F;
  }
  // All cells that are not 0 are in it.
  const CellBox& Box() const { return box_; }

  // For ceres::BiCubicInterpolator: rows and columns of one value.
  enum { DATA_DIMENSION = 1 };
  void GetValue(int row, int column, double* value) const { *value = At(column, row); }

 private:
  bool Contains(int column, int row) const {
    return column >= 0 && row >= 0 && column < size_ && row < size_;
  }
  std::size_t Index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(size_) +
           static_cast<std::size_t>(column);
  }

  LikelihoodFieldOptions options_;
  int size_;
  std::vector<float> cells_;
  CellBox box_;
};

}  // namespace nightmap
