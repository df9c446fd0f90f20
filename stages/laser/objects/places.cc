// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/objects/places.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

constexpr int kBlurSide = 9;
constexpr double kBlurSigma = 1.5;  // cells; wide enough for slanted walls to look straight
constexpr int kMaxShifts = 50;

struct Disc {
  Eigen::Vector2d center;
  double radius = 0;

  // Calls visit(cell) for the cells of the grid whose centre is in the disc.
  template <typename Visit>
  void ForEach(const OccupancyGrid& grid, const Visit& visit) const {
    const Eigen::Array2i first = (center.array() - radius).ceil().cast<int>().max(0);
    const Eigen::Array2i last = (center.array() + radius)
                                    .floor()
                                    .cast<int>()
                                    .min(Eigen::Array2i(grid.width - 1, grid.height - 1));
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        const Eigen::Vector2i cell(x, y);
        if ((cell.cast<double>() - center).squaredNorm() <= radius * radius) visit(cell);
      }
    }
  }
};

// How the blurred occupied cells change from cell to cell.
class Gradients {
 public:
  explicit Gradients(const OccupancyGrid& grid) : grid_(grid) {
    cv::Mat occupied(grid.height, grid.width, CV_64F);
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        occupied.at<double>(y, x) = grid.At({x, y}) == kOccupiedCell ? 1 : 0;
      }
    }
    cv::GaussianBlur(
        occupied, blurred_, {kBlurSide, kBlurSide}, kBlurSigma, kBlurSigma, cv::BORDER_CONSTANT);
  }

  Eigen::Vector2d At(const Eigen::Vector2i& cell) const {
    return {Blurred(cell.x() + 1, cell.y()) - Blurred(cell.x() - 1, cell.y()),
            Blurred(cell.x(), cell.y() + 1) - Blurred(cell.x(), cell.y() - 1)};
  }

  // Sum of the squares of the gradients across a wall that is one cell thick.
  static double OfAWall() {
    const cv::Mat kernel = cv::getGaussianKernel(kBlurSide, kBlurSigma, CV_64F);
    const auto at = [&](int i) { return i < 0 || i >= kBlurSide ? 0 : kernel.at<double>(i); };
    double sum = 0;
    for (int i = -1; i <= kBlurSide; ++i) sum += std::pow(at(i + 1) - at(i - 1), 2);
    return sum;
  }

 private:
  double Blurred(int x, int y) const {
    return grid_.Contains({x, y}) ? blurred_.at<double>(y, x) : 0;
  }

  const OccupancyGrid& grid_;
  cv::Mat blurred_;
};

bool IsBesideFree(const OccupancyGrid& grid, const Eigen::Vector2i& cell) {
  for (const auto& [x, y] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
    const Eigen::Vector2i beside = cell + Eigen::Vector2i(x, y);
    if (grid.Contains(beside) && grid.At(beside) == kFreeCell) return true;
  }
  return false;
}

// The cell that the occupied cells of a disc about it have in their middle.
Eigen::Vector2i ShiftToMean(const OccupancyGrid& grid, const Eigen::Vector2i& from, double radius) {
  Eigen::Vector2d center = from.cast<double>();
  for (int i = 0; i < kMaxShifts; ++i) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    int count = 0;
    Disc{center, radius}.ForEach(grid, [&](const Eigen::Vector2i& cell) {
      if (grid.At(cell) != kOccupiedCell) return;
      sum += cell.cast<double>();
      ++count;
    });
    if (count == 0 || sum / count == center) break;
    center = sum / count;
  }
  return center.array().round().cast<int>();
}

Place PlaceAt(const OccupancyGrid& grid,
              const Gradients& gradients,
              const Eigen::Vector2i& center,
              double radius) {
  Place place;
  place.center = center;
  Eigen::Matrix2d tensor = Eigen::Matrix2d::Zero();
  std::complex<double> direction;  // its angle is four times that of the walls
  int num_seen = 0;
  Disc{center.cast<double>(), radius}.ForEach(grid, [&](const Eigen::Vector2i& cell) {
    const Eigen::Vector2d gradient = gradients.At(cell);
    tensor += gradient * gradient.transpose();
    const std::complex<double> across(gradient.x(), gradient.y());
    if (across != 0.0) direction += std::pow(across, 4) / std::norm(across);
    if (grid.At(cell) != kOccupiedCell) return;
    place.cells.push_back(cell);
    num_seen += IsBesideFree(grid, cell) ? 1 : 0;
  });
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(tensor, Eigen::EigenvaluesOnly);
  place.wall = solver.eigenvalues()[0] / Gradients::OfAWall();
  place.heading_rad = std::arg(direction) / 4;
  place.straightness = std::abs(direction) / std::max(1e-9, tensor.trace());
  place.seen_share = num_seen / std::max<double>(1, static_cast<double>(place.cells.size()));
  return place;
}

}  // namespace

std::vector<Place> FindPlaces(const OccupancyGrid& grid,
                              double radius,
                              double min_wall,
                              int num_threads) {
  std::vector<std::vector<Eigen::Vector2i>> centers(static_cast<std::size_t>(grid.height));
  ParallelFor(centers.size(), num_threads, [&](std::size_t y) {
    for (Eigen::Vector2i cell(0, y); cell.x() < grid.width; ++cell.x()) {
      if (grid.At(cell) == kOccupiedCell) centers[y].push_back(ShiftToMean(grid, cell, radius));
    }
  });
  std::map<std::pair<int, int>, Eigen::Vector2i> distinct;
  for (const auto& row : centers) {
    for (const Eigen::Vector2i& center : row)
      distinct.emplace(std::pair(center.y(), center.x()), center);
  }
  const Gradients gradients(grid);
  std::vector<Place> places;
  for (const auto& [key, center] : distinct) {
    Place place = PlaceAt(grid, gradients, center, radius);
    if (place.wall >= min_wall) places.push_back(std::move(place));
  }
  std::ranges::stable_sort(places, std::ranges::greater(), &Place::wall);
  return places;
}

}  // namespace nightmap
