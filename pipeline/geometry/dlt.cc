// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/dlt.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace nightmap {
namespace {

using Matrix34d = Eigen::Matrix<double, 3, 4>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;
using Vector12d = Eigen::Matrix<double, 12, 1>;

// normalized = scale * (point - centroid), so that the mean distance from the origin is sqrt(3).
struct Normalization {
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  double scale = 1;
};

Normalization Normalize(const std::vector<Eigen::Vector3d>& points) {
  Normalization result;
  const auto count = static_cast<double>(points.size());
  for (const Eigen::Vector3d& point : points) result.centroid += point / count;
  double mean_m = 0;
  for (const Eigen::Vector3d& point : points) mean_m += (point - result.centroid).norm() / count;
  result.scale = std::sqrt(3.0) / mean_m;
  return result;
}

// The 3 x 4 matrix, of norm 1 and either sign, that maps normalized points to rays.
std::optional<Matrix34d> SolveLinear(const std::vector<Eigen::Vector2d>& rays,
                                     const std::vector<Eigen::Vector3d>& points,
                                     const Normalization& normalization) {
  Matrix12d normal = Matrix12d::Zero();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector4d point =
        (normalization.scale * (points[i] - normalization.centroid)).homogeneous();
    for (int axis = 0; axis < 2; ++axis) {
      Vector12d row = Vector12d::Zero();
      row.segment<4>(4 * axis) = point;
      row.tail<4>() = -rays[i][axis] * point;
      normal += row * row.transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Matrix12d> solver(normal);
  // If a second direction has no error either, the points are degenerate.
  constexpr double kMinRatio = 1e-10;
  if (solver.info() != Eigen::Success ||
      !(solver.eigenvalues()[1] > kMinRatio * solver.eigenvalues()[11])) {
    return std::nullopt;
  }
  const Vector12d p = solver.eigenvectors().col(0);
  Matrix34d matrix;
  matrix << p.segment<4>(0).transpose(), p.segment<4>(4).transpose(), p.segment<4>(8).transpose();
  return matrix;
}

// The nearest rigid transform of positive scale; nothing when only a reflection is near.
std::optional<Rigid3> ToRigid(const Matrix34d& matrix, const Normalization& normalization) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix.leftCols<3>(),
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  const double scale = (rotation.transpose() * matrix.leftCols<3>()).trace() / 3;
  if (rotation.determinant() <= 0 || !(scale > 0)) return std::nullopt;
  // matrix * normalized = scale * (rotation * normalized + shift), in units of 1 / normalization.
  const Eigen::Vector3d shift = matrix.col(3) / scale;
  return Rigid3{Eigen::Quaterniond(rotation),
                shift / normalization.scale - rotation * normalization.centroid};
}

}  // namespace

std::optional<Rigid3> SolveDlt(const std::vector<Eigen::Vector2d>& rays,
                               const std::vector<Eigen::Vector3d>& points_in_world) {
  if (rays.size() != points_in_world.size() || rays.size() < kDltSampleSize) {
    throw std::invalid_argument("SolveDlt: not six or more rays, one for each point");
  }
  const Normalization normalization = Normalize(points_in_world);
  if (!std::isfinite(normalization.scale)) return std::nullopt;
  const auto matrix = SolveLinear(rays, points_in_world, normalization);
  if (!matrix) return std::nullopt;
  for (const double sign : {1.0, -1.0}) {
    const auto pose = ToRigid(sign * *matrix, normalization);
    if (!pose) continue;
    const bool is_in_front =
        std::all_of(points_in_world.begin(), points_in_world.end(), [&](const auto& point) {
          return (*pose * point).z() > 0;
        });
    if (is_in_front) return pose;
  }
  return std::nullopt;
}

}  // namespace nightmap
