// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "pipeline/world/furniture.h"

namespace nightmap {

namespace {

struct Bounds {
  Eigen::Vector3d low, high;
};

Bounds BoundsOf(const Box& box) {
  const double c = std::abs(std::cos(box.yaw_rad));
  const double s = std::abs(std::sin(box.yaw_rad));
  const Eigen::Vector3d reach(c * box.half_size.x() + s * box.half_size.y(),
                              s * box.half_size.x() + c * box.half_size.y(),
                              box.half_size.z());
  return {box.center - reach, box.center + reach};
}

bool Intersect(const Bounds& a, const Bounds& b) {
  constexpr double kTolerance_m = 1e-3;
  return (a.low.array() < b.high.array() - kTolerance_m).all() &&
         (b.low.array() < a.high.array() - kTolerance_m).all();
}

}  // namespace

Eigen::Vector2d Placement::ToBuilding(const Eigen::Vector2d& point) const {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  return origin + Eigen::Vector2d(c * point.x() - s * point.y(), s * point.x() + c * point.y());
}

void Piece::Add(const Eigen::Vector3d& low,
                const Eigen::Vector3d& high,
                SurfaceLabel label,
                const Material& material,
                double yaw_rad,
                const Material* picture) {
  const Eigen::Vector3d center = (low + high) / 2;
  const Eigen::Vector2d center_in_building = placement_.ToBuilding(center.head<2>());
  Part part;
  part.box.center = {center_in_building.x(), center_in_building.y(), center.z()};
  part.box.half_size = (high - low) / 2;
  // Adds half a turn, so that the box's front (-y) is the side away from the wall.
  part.box.yaw_rad =
      std::remainder(placement_.yaw_rad + yaw_rad + std::numbers::pi, 2 * std::numbers::pi);
  part.box.label = label;
  part.material = material;
  part.has_picture = picture != nullptr;
  if (part.has_picture) part.picture = *picture;
  parts_.push_back(part);
}

double Piece::Distance(const std::vector<Eigen::Vector2d>& points) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Part& part : parts_) {
    for (const Eigen::Vector2d& point : points) {
      smallest = std::min(smallest, HorizontalDistance(part.box, point));
    }
  }
  return smallest;
}

bool Piece::Overlaps(const std::vector<Box>& boxes) const {
  for (const Part& part : parts_) {
    const Bounds bounds = BoundsOf(part.box);
    const auto hits = [&](const Box& box) { return Intersect(bounds, BoundsOf(box)); };
    if (std::any_of(boxes.begin(), boxes.end(), hits)) return true;
  }
  return false;
}

void Piece::Commit() {
  const int piece_idx = builder_->AddPiece();
  for (Part& part : parts_) {
    part.box.piece_idx = piece_idx;
    builder_->AddBox(part.box, part.material, part.has_picture ? &part.picture : nullptr);
  }
}

std::vector<Box> Piece::Boxes() const {
  std::vector<Box> boxes;
  for (const Part& part : parts_) boxes.push_back(part.box);
  return boxes;
}

}  // namespace nightmap
