// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/visible_surfaces.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

namespace nightmap {

namespace {

constexpr int kTile_px = 8;
// Rays are cast in single precision, so these margins are far above its rounding.
constexpr double kEdgeMargin = 1e-4;      // in the plane z = 1
constexpr double kNearnessMargin = 2e-5;  // relative
constexpr double kPlaneMargin_m = 1e-5;   // of the camera's distance from a surface's plane

}  // namespace

VisibleSurfaces::VisibleSurfaces(const std::vector<Surface>& surfaces,
                                 const Camera& camera,
                                 const Rigid3& building_from_camera)
    : camera_(camera),
      num_columns_((camera.width + kTile_px - 1) / kTile_px),
      num_rows_((camera.height + kTile_px - 1) / kTile_px),
      tiles_(static_cast<std::size_t>(num_columns_ * num_rows_)) {
  const Rigid3 camera_from_building = building_from_camera.Inverse();
  outlines_.reserve(surfaces.size());
  for (const Surface& surface : surfaces) {
    outlines_.push_back(
        MakeOutline(surface, static_cast<int>(outlines_.size()), camera_from_building));
  }
  std::vector<int> all(outlines_.size());
  std::iota(all.begin(), all.end(), 0);
  const auto longest_px = static_cast<unsigned>(std::max({camera.width, camera.height, kTile_px}));
  Divide({0, 0, static_cast<int>(std::bit_ceil(longest_px))}, all);
}

VisibleSurfaces::Outline VisibleSurfaces::MakeOutline(const Surface& surface,
                                                      int surface_idx,
                                                      const Rigid3& camera_from_building) {
  const Eigen::Vector3d origin = camera_from_building * surface.origin;
  const Eigen::Vector3d u = camera_from_building.rotation * surface.edge_u;
  const Eigen::Vector3d v = camera_from_building.rotation * surface.edge_v;
  const Eigen::Vector3d normal = u.cross(v).normalized();
  const double distance_m = normal.dot(origin);  // of the camera from the plane, with sign
  const std::array<Eigen::Vector3d, 4> corners = {origin, origin + u, origin + u + v, origin + v};
  Outline outline;
  // An edge and the camera span a plane, which meets the plane z = 1 in the edge's line.
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d line =
        std::copysign(1.0, distance_m) * corners[i].cross(corners[(i + 1) % 4]);
    const Eigen::Vector3d unit = line / std::max(line.head<2>().norm(), 1e-12);
    const auto k = static_cast<Eigen::Index>(i);
    outline.edge_x[k] = unit.x();
    outline.edge_y[k] = unit.y();
    outline.edge_1[k] = unit.z();
  }
  const double safe_distance_m = std::copysign(std::max(std::abs(distance_m), 1e-9), distance_m);
  outline.nearness_per_m = normal / safe_distance_m;
  outline.tolerance = std::min(1.0, kNearnessMargin + kPlaneMargin_m / std::abs(safe_distance_m));
  outline.surface_idx = surface_idx;
  return outline;
}

Eigen::Vector3d VisibleSurfaces::PointAt(double x, double y) const {
  return {(x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy, 1};
}

std::vector<int> VisibleSurfaces::Prune(const Square& square,
                                        std::span<const int> candidates,
                                        bool& is_covered) const {
  const double half_px = 0.5 * square.size_px;
  const Eigen::Vector3d center = PointAt(square.x0 + half_px - 0.5, square.y0 + half_px - 0.5);
  const Eigen::Vector2d reach(half_px / camera_.fx, half_px / camera_.fy);
  std::vector<int> kept;
  std::vector<double> most_nearness;  // of those kept
  double covered_to = 0;              // nearness of the nearest surface that covers the square
  for (const int candidate : candidates) {
    const Outline& outline = outlines_[static_cast<std::size_t>(candidate)];
    const Eigen::Array4d middle =
        outline.edge_x * center.x() + outline.edge_y * center.y() + outline.edge_1;
    const Eigen::Array4d spread =
        outline.edge_x.abs() * reach.x() + outline.edge_y.abs() * reach.y();
    if ((middle + spread).minCoeff() < -kEdgeMargin) continue;
    const double nearness = outline.nearness_per_m.dot(center);
    const double change = outline.nearness_per_m.head<2>().cwiseAbs().dot(reach);
    kept.push_back(candidate);
    most_nearness.push_back((nearness + change) * (1 + outline.tolerance));
    if ((middle - spread).minCoeff() < kEdgeMargin) continue;
    covered_to = std::max(covered_to, (nearness - change) * (1 - outline.tolerance));
  }
  std::size_t num_kept = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (most_nearness[i] >= covered_to) kept[num_kept++] = kept[i];
  }
  kept.resize(num_kept);
  is_covered = num_kept == 1 && covered_to > 0;
  return kept;
}

void VisibleSurfaces::Divide(const Square& square, std::span<const int> candidates) {
  if (square.x0 >= camera_.width || square.y0 >= camera_.height) return;
  bool is_covered = false;
  const std::vector<int> kept = Prune(square, candidates, is_covered);
  if (is_covered || square.size_px == kTile_px) return Store(square, kept, is_covered);
  const int half_px = square.size_px / 2;
  for (const int y0 : {square.y0, square.y0 + half_px}) {
    for (const int x0 : {square.x0, square.x0 + half_px}) Divide({x0, y0, half_px}, kept);
  }
}

void VisibleSurfaces::Store(const Square& square,
                            std::span<const int> candidates,
                            bool is_covered) {
  const Tile tile{candidates_.size(), candidates.size(), is_covered};
  candidates_.insert(candidates_.end(), candidates.begin(), candidates.end());
  const int end_column = std::min(num_columns_, (square.x0 + square.size_px) / kTile_px);
  const int end_row = std::min(num_rows_, (square.y0 + square.size_px) / kTile_px);
  for (int row = square.y0 / kTile_px; row < end_row; ++row) {
    for (int column = square.x0 / kTile_px; column < end_column; ++column) {
      tiles_[static_cast<std::size_t>(row * num_columns_ + column)] = tile;
    }
  }
}

std::optional<int> VisibleSurfaces::At(double x, double y) const {
  const Eigen::Vector2d from_corner(x + 0.5, y + 0.5);  // the picture's
  const int column = static_cast<int>(from_corner.x()) / kTile_px;
  const int row = static_cast<int>(from_corner.y()) / kTile_px;
  const Tile& tile = tiles_[static_cast<std::size_t>(row * num_columns_ + column)];
  const std::span<const int> candidates(candidates_.data() + tile.first, tile.count);
  if (tile.is_covered) return outlines_[static_cast<std::size_t>(candidates[0])].surface_idx;
  const Eigen::Vector3d point = PointAt(x, y);
  std::optional<int> nearest;
  double nearest_least = 0;  // bounds of its nearness
  double nearest_most = 0;
  double others_most = 0;
  for (const int candidate : candidates) {
    const Outline& outline = outlines_[static_cast<std::size_t>(candidate)];
    const Eigen::Array4d inside =
        outline.edge_x * point.x() + outline.edge_y * point.y() + outline.edge_1;
    const double smallest = inside.minCoeff();
    if (smallest < -kEdgeMargin) continue;
    const double nearness = outline.nearness_per_m.dot(point);
    const double least = nearness * (1 - outline.tolerance);
    double most = nearness * (1 + outline.tolerance);
    if (smallest > kEdgeMargin && least > nearest_least) {
      // The one so far becomes one of the others.
      nearest = outline.surface_idx;
      nearest_least = least;
      std::swap(most, nearest_most);
    }
    others_most = std::max(others_most, most);
  }
  return others_most < nearest_least ? nearest : std::nullopt;
}

}  // namespace nightmap
