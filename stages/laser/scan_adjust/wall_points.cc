// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/wall_points.h"

#include <Eigen/Eigenvalues>
#include <optional>

namespace nightmap {
namespace {

constexpr std::size_t kNumEachSide = 3;  // neighbours that make a line
// Neighbours are no farther from each other than this, or than this times their distance from the
// robot: beams of a degree are 0.017 apart, on an oblique wall more.
constexpr double kMaxGap_m = 0.15;
constexpr double kMaxGapRatio = 0.06;
constexpr double kMaxRms_m = 0.03;  // of the neighbours, across the line

// The normal of the line through the neighbours of point i; none: they make no line.
std::optional<Eigen::Vector2d> NormalAt(const std::vector<Eigen::Vector2d>& points, std::size_t i) {
  if (i < kNumEachSide || i + kNumEachSide >= points.size()) return std::nullopt;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::size_t k = i - kNumEachSide; k <= i + kNumEachSide; ++k) mean += points[k];
  mean /= 2 * kNumEachSide + 1;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (std::size_t k = i - kNumEachSide; k <= i + kNumEachSide; ++k) {
    const double max_gap_m = std::max(kMaxGap_m, kMaxGapRatio * points[k].norm());
    if (k > i - kNumEachSide && (points[k] - points[k - 1]).norm() > max_gap_m) return std::nullopt;
    covariance += (points[k] - mean) * (points[k] - mean).transpose();
  }
  covariance /= 2 * kNumEachSide + 1;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance);
  if (axes.eigenvalues()[0] > kMaxRms_m * kMaxRms_m ||
      axes.eigenvalues()[0] >= 0.1 * axes.eigenvalues()[1]) {
    return std::nullopt;
  }
  const Eigen::Vector2d normal = axes.eigenvectors().col(0);
  return normal.dot(points[i]) > 0 ? -normal : normal;
}

}  // namespace

std::vector<WallPoint> FindWallPoints(const std::vector<Eigen::Vector2d>& points_in_robot,
                                      double spacing_m) {
  std::vector<WallPoint> found;
  for (std::size_t i = 0; i < points_in_robot.size(); ++i) {
    const Eigen::Vector2d& point = points_in_robot[i];
    if (!found.empty() && (point - found.back().point_in_robot).norm() < spacing_m) continue;
    if (const auto normal = NormalAt(points_in_robot, i)) found.push_back({point, *normal});
  }
  return found;
}

}  // namespace nightmap
