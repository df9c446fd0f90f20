// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/wall_normals.h"

#include <Eigen/Eigenvalues>

namespace nightmap {
namespace {

constexpr double kMaxWidthRatio = 0.1;  // of the mean square across a line over that along it

struct Line {
  Eigen::Vector2d normal;
  double mean_square_m2 = 0;  // across it
};

Line LineThrough(const std::vector<Eigen::Vector2d>& points, std::size_t first) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::size_t i = first; i < first + kWallPoints; ++i) mean += points[i] / kWallPoints;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (std::size_t i = first; i < first + kWallPoints; ++i) {
    covariance += (points[i] - mean) * (points[i] - mean).transpose() / kWallPoints;
  }
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes;
  axes.computeDirect(covariance);
  const Eigen::Vector2d& squares_m2 = axes.eigenvalues();
  const bool is_line = squares_m2[0] < kMaxWidthRatio * squares_m2[1];
  return {axes.eigenvectors().col(0), is_line ? squares_m2[0] : 1e9};
}

}  // namespace

std::vector<Eigen::Vector2d> WallNormals(const std::vector<Eigen::Vector2d>& points,
                                         double max_rms_m) {
  std::vector<Eigen::Vector2d> normals(points.size(), Eigen::Vector2d::Zero());
  std::vector<double> best_m2(points.size(), max_rms_m * max_rms_m);
  for (std::size_t first = 0; first + kWallPoints <= points.size(); ++first) {
    const Line line = LineThrough(points, first);
    for (std::size_t i = first; i < first + kWallPoints; ++i) {
      if (line.mean_square_m2 >= best_m2[i]) continue;
      best_m2[i] = line.mean_square_m2;
      normals[i] = line.normal;
    }
  }
  return normals;
}

}  // namespace nightmap
