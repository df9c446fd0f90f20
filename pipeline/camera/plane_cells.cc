// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/plane_cells.h"

#include <algorithm>
#include <span>

namespace nightmap {
namespace {

class Cutter {
 public:
  Cutter(std::size_t max_positions, double min_extent_m)
      : max_positions_(max_positions), min_extent_m_(min_extent_m) {}

  void Cut(const Rectangle& box, std::span<Eigen::Vector2d> positions) {
    if (positions.size() <= max_positions_) return Keep(box, positions);
    Eigen::Vector2d low_m = positions.front(), high_m = positions.front();
    for (const Eigen::Vector2d& position : positions) {
      low_m = low_m.cwiseMin(position);
      high_m = high_m.cwiseMax(position);
    }
    int axis = 0;
    const double extent_m = (high_m - low_m).maxCoeff(&axis);
    if (extent_m < min_extent_m_ || extent_m <= 0) return Keep(box, positions);
    const double border_m = Border(axis, low_m[axis], positions);
    const auto above =
        std::partition(positions.begin(), positions.end(), [&](const auto& position) {
          return position[axis] < border_m;
        });
    const auto num_below = static_cast<std::size_t>(above - positions.begin());
    Rectangle below_box = box, above_box = box;
    below_box.max_m[axis] = above_box.min_m[axis] = border_m;
    Cut(below_box, positions.first(num_below));
    Cut(above_box, positions.subspan(num_below));
  }

  std::vector<PlaneCell> Take() { return std::move(cells_); }

 private:
  void Keep(const Rectangle& box, std::span<const Eigen::Vector2d> positions) {
    cells_.push_back({box, positions.size()});
  }

  // The median, or the next coordinate above the lowest: neither side is empty.
  static double Border(int axis, double lowest_m, std::span<const Eigen::Vector2d> positions) {
    std::vector<double> coordinates;
    for (const Eigen::Vector2d& position : positions) coordinates.push_back(position[axis]);
    std::ranges::sort(coordinates);
    const double median_m = coordinates[coordinates.size() / 2];
    if (median_m > lowest_m) return median_m;
    return *std::ranges::upper_bound(coordinates, lowest_m);
  }

  std::size_t max_positions_;
  double min_extent_m_;
  std::vector<PlaneCell> cells_;
};

}  // namespace

std::vector<PlaneCell> CutPlane(std::vector<Eigen::Vector2d> positions,
                                std::size_t max_positions,
                                double min_extent_m) {
  Cutter cutter(max_positions, min_extent_m);
  cutter.Cut({}, positions);
  return cutter.Take();
}

}  // namespace nightmap
