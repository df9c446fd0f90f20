// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/scene.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace nightmap {

namespace {

constexpr std::array<const char*, kNumSurfaceLabels> kLabelNames = {"none",
                                                                    "wall",
                                                                    "floor",
                                                                    "ceiling",
                                                                    "door",
                                                                    "table",
                                                                    "chair",
                                                                    "shelf",
                                                                    "cabinet",
                                                                    "bed",
                                                                    "sofa",
                                                                    "poster",
                                                                    "object",
                                                                    "lamp"};

Eigen::Vector3d RotateAboutZ(const Eigen::Vector3d& vector, double yaw_rad) {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  return {c * vector.x() - s * vector.y(), s * vector.x() + c * vector.y(), vector.z()};
}

// The face with outward normal `normal` (box frame, an axis); v runs along `down`.
Surface BoxFace(const Box& box,
                const Eigen::Vector3d& normal,
                const Eigen::Vector3d& down,
                const Material& material) {
  const Eigen::Vector3d right = normal.cross(down);
  const Eigen::Vector3d half_u = right.cwiseProduct(box.half_size);
  const Eigen::Vector3d half_v = down.cwiseProduct(box.half_size);
  const Eigen::Vector3d middle = normal.cwiseProduct(box.half_size);
  Surface face;
  face.origin = box.center + RotateAboutZ(middle - half_u - half_v, box.yaw_rad);
  face.edge_u = RotateAboutZ(2 * half_u, box.yaw_rad);
  face.edge_v = RotateAboutZ(2 * half_v, box.yaw_rad);
  face.label = box.label;
  face.piece_idx = box.piece_idx;
  face.material = material;
  return face;
}

}  // namespace

const char* LabelName(SurfaceLabel label) { return kLabelNames[static_cast<std::size_t>(label)]; }

void AddScene(Scene part, double height_m, Scene& whole) {
  const Eigen::Vector3d raise(0, 0, height_m);
  const int num_textures = static_cast<int>(whole.textures.size());
  const auto count_on = [&](int& piece_idx) {
    if (piece_idx >= 0) piece_idx += whole.num_pieces;
  };
  for (Box& box : part.boxes) {
    box.center += raise;
    count_on(box.piece_idx);
  }
  for (Lamp& lamp : part.lamps) lamp.center += raise;
  for (Surface& surface : part.surfaces) {
    surface.origin += raise;
    count_on(surface.piece_idx);
    surface.material.texture_idx += num_textures;
    if (surface.material.overlay_idx >= 0) surface.material.overlay_idx += num_textures;
  }
  const auto append = [](auto&& from, auto& to) {
    to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
  };
  append(part.textures, whole.textures);
  append(part.boxes, whole.boxes);
  append(part.surfaces, whole.surfaces);
  append(part.lamps, whole.lamps);
  whole.num_pieces += part.num_pieces;
}

std::array<Surface, 6> BoxFaces(const Box& box, const Material& material) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  return {BoxFace(box, -y, -z, material),
          BoxFace(box, x, -z, material),
          BoxFace(box, y, -z, material),
          BoxFace(box, -x, -z, material),
          BoxFace(box, z, -y, material),
          BoxFace(box, -z, y, material)};
}

double HorizontalDistance(const Box& box, const Eigen::Vector2d& point) {
  const Eigen::Vector3d offset(point.x() - box.center.x(), point.y() - box.center.y(), 0);
  const Eigen::Vector3d in_box = RotateAboutZ(offset, -box.yaw_rad);
  const double dx = std::max(0.0, std::abs(in_box.x()) - box.half_size.x());
  const double dy = std::max(0.0, std::abs(in_box.y()) - box.half_size.y());
  return std::hypot(dx, dy);
}

double Clearance(const std::vector<Box>& boxes,
                 const Eigen::Vector2d& point,
                 double min_height_m,
                 double max_height_m) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Box& box : boxes) {
    const bool is_in_band = box.center.z() - box.half_size.z() < max_height_m &&
                            box.center.z() + box.half_size.z() > min_height_m;
    if (is_in_band) smallest = std::min(smallest, HorizontalDistance(box, point));
  }
  return smallest;
}

}  // namespace nightmap
