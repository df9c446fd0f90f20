// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/boundary_refine.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace nightmap {
namespace {

constexpr int kMaxIterations = 30;
constexpr double kConverged = 1e-5;    // m and rad
constexpr double kGateShrink = 0.8;    // per iteration
constexpr double kMinGate_cells = 3;   // what noise and the width of walls leave
constexpr int kWallReach_cells = 3;    // the direction of a wall is that of the cells within
constexpr double kMaxFlatness = 0.15;  // smaller over larger variance of the cells of a line
constexpr double kPriorSigma_m = 0.3;  // as in FindCandidates
constexpr double kPriorSigma_rad = 0.1;

// The wall next to a point: rows of `normals` are the directions that it is known in.
struct NearWall {
  Eigen::Vector2d point_in_map;
  Eigen::Matrix<double, Eigen::Dynamic, 2, 0, 2, 2> normals;
};

// The occupied cell nearest to a cell that is so far from it. Equal ones always give the same.
Eigen::Vector2i NearestWall(const ScanMap& map, const Eigen::Vector2i& cell) {
  const double distance_cells = map.WallDistance_m(cell) / map.Grid().resolution_m;
  const long squared = std::lround(distance_cells * distance_cells);
  const int reach = static_cast<int>(std::ceil(distance_cells));
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      if (long{x} * x + long{y} * y != squared) continue;
      const Eigen::Vector2i other = cell + Eigen::Vector2i(x, y);
      if (map.Grid().Contains(other) && map.Grid().At(other) == kOccupiedCell) return other;
    }
  }
  return cell;
}

NearWall WallAt(const OccupancyGrid& grid, const Eigen::Vector2i& cell) {
  Eigen::Vector2d sum(0, 0);
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  double count = 0;
  const Eigen::Vector2d center = grid.CenterInMap(cell);
  for (int y = -kWallReach_cells; y <= kWallReach_cells; ++y) {
    for (int x = -kWallReach_cells; x <= kWallReach_cells; ++x) {
      const Eigen::Vector2i other = cell + Eigen::Vector2i(x, y);
      if (!grid.Contains(other) || grid.At(other) != kOccupiedCell) continue;
      const Eigen::Vector2d offset = grid.CenterInMap(other) - center;
      sum += offset;
      squares += offset * offset.transpose();
      ++count;
    }
  }
  const Eigen::Vector2d mean = sum / count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(squares / count -
                                                              mean * mean.transpose());
  const Eigen::Vector2d& variances = solver.eigenvalues();  // the smaller first
  if (count < 3 || variances[0] > kMaxFlatness * variances[1]) {
    return {center, Eigen::Matrix2d::Identity()};
  }
  return {center + mean, solver.eigenvectors().col(0).transpose()};
}

std::optional<NearWall> WallNear(const ScanMap& map, const Eigen::Vector2d& point, double gate_m) {
  const Eigen::Vector2i cell = map.Grid().CellOf(point);
  if (!map.Grid().Contains(cell) || map.WallDistance_m(cell) > gate_m) return std::nullopt;
  return WallAt(map.Grid(), NearestWall(map, cell));
}

struct NormalEquations {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0;
  int num_residuals = 0;
};

NormalEquations EquationsAt(const ScanMap& map,
                            const std::vector<Eigen::Vector2d>& points_in_query,
                            const Rigid2& pose,
                            double gate_m) {
  NormalEquations equations;
  for (const Eigen::Vector2d& point : points_in_query) {
    const Eigen::Vector2d in_map = pose * point;
    const auto wall = WallNear(map, in_map, gate_m);
    if (!wall) continue;
    const Eigen::Vector2d arm = in_map - pose.translation;
    for (Eigen::Index i = 0; i < wall->normals.rows(); ++i) {
      const Eigen::Vector2d normal = wall->normals.row(i);
      const double residual = normal.dot(in_map - wall->point_in_map);
      const Eigen::Vector3d gradient(
          normal.x(), normal.y(), normal.dot(Eigen::Vector2d(-arm.y(), arm.x())));
      equations.matrix += gradient * gradient.transpose();
      equations.right -= residual * gradient;
      equations.squares += residual * residual;
      ++equations.num_residuals;
    }
  }
  return equations;
}

}  // namespace

Rigid2 RefineOnBoundary(const ScanMap& map,
                        const std::vector<Eigen::Vector2d>& points_in_query,
                        const Rigid2& start,
                        double gate_m) {
  const double cell_m = map.Grid().resolution_m;
  const Eigen::Vector3d prior_sigmas(kPriorSigma_m, kPriorSigma_m, kPriorSigma_rad);
  const Eigen::Matrix3d prior = prior_sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
  Rigid2 pose = start;
  for (int i = 0; i < kMaxIterations; ++i) {
    const NormalEquations equations = EquationsAt(map, points_in_query, pose, gate_m);
    // No residual is known better than half a cell.
    const double variance =
        std::max(cell_m * cell_m / 4, equations.squares / std::max(1, equations.num_residuals));
    const Eigen::Matrix3d information = equations.matrix / variance + prior;
    const Eigen::Vector3d from_start(start.translation.x() - pose.translation.x(),
                                     start.translation.y() - pose.translation.y(),
                                     WrapAngle_rad(start.heading_rad - pose.heading_rad));
    const Eigen::Vector3d step =
        information.ldlt().solve(equations.right / variance + prior * from_start);
    pose.translation += step.head<2>();
    pose.heading_rad = WrapAngle_rad(pose.heading_rad + step.z());
    const double next_gate_m = std::max(kMinGate_cells * cell_m, kGateShrink * gate_m);
    if (step.norm() < kConverged && next_gate_m >= gate_m) break;
    gate_m = next_gate_m;
  }
  return pose;
}

}  // namespace nightmap
