// SPDX-License-Identifier: Apache-2.0
// Geometry of the synthetic building: boxes (truth about obstacles) and textured parallelograms
// (what a camera sees). Building frame: z up, floor at z = 0, metres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/world/texture.h"

namespace nightmap {

// Class of a surface, as stored in label images.
enum class SurfaceLabel : std::uint8_t {
  kNone = 0,
  kWall,
  kFloor,
  kCeiling,
  kDoor,
  kTable,
  kChair,
  kShelf,
  kCabinet,
  kBed,
  kSofa,
  kPoster,
  kObject,
  kLamp,
};
inline constexpr int kNumSurfaceLabels = 14;
const char* LabelName(SurfaceLabel label);

struct Rect2 {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool Contains(double x, double y) const { return x >= x0 && x <= x1 && y >= y0 && y <= y1; }
  double Area() const { return (x1 - x0) * (y1 - y0); }
};

// Solid upright box.
struct Box {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_size = Eigen::Vector3d::Zero();
  double yaw_rad = 0;  // about z
  SurfaceLabel label = SurfaceLabel::kNone;
  int piece_idx = -1;  // of the furniture, door or poster that it is part of; -1: of none
};

// Color of a surface: color = texture(uv / period + offset) * tint * overlay / 128.
struct Material {
  int texture_idx = 0;
  double period_m = 1;  // length of one repeat of the texture; 0: stretched once over the surface
  Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();
  double rotation_rad = 0;
  Eigen::Vector3f tint = Eigen::Vector3f::Ones();
  int overlay_idx = -1;  // -1: none
  double overlay_period_m = 1;
  float glow = 0;  // emitted light, relative to the texture
};

// Parallelogram origin + a * edge_u + b * edge_v, a and b in [0, 1]. From its front, u points right
// and v down. Both sides are rendered alike.
struct Surface {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d edge_u = Eigen::Vector3d::UnitX();
  Eigen::Vector3d edge_v = Eigen::Vector3d::UnitY();
  SurfaceLabel label = SurfaceLabel::kNone;
  Material material;
  int piece_idx = -1;  // of its box
  // Unit normal, towards the side it is seen from.
  Eigen::Vector3d Normal() const { return edge_v.cross(edge_u).normalized(); }
};

// Horizontal lamp in the ceiling that shines down.
struct Lamp {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector2d half_size = Eigen::Vector2d::Zero();
  float intensity = 1;
};

struct Scene {
  std::vector<Texture> textures;
  std::vector<Box> boxes;
  std::vector<Surface> surfaces;
  std::vector<Lamp> lamps;
  int num_pieces = 0;  // piece_idx counts them
};

// Adds the part to the whole, raised by `height_m`. Its pieces count on from those of the whole.
void AddScene(Scene part, double height_m, Scene& whole);

// The faces of a box as surfaces: front (-y in the box frame), right (+x), back, left, top, bottom.
std::array<Surface, 6> BoxFaces(const Box& box, const Material& material);

// Distance in the horizontal plane from a point to a box's footprint; 0 inside.
double HorizontalDistance(const Box& box, const Eigen::Vector2d& point);

// Smallest HorizontalDistance to the boxes that reach into the height band. Infinity without boxes.
double Clearance(const std::vector<Box>& boxes,
                 const Eigen::Vector2d& point,
                 double min_height_m,
                 double max_height_m);

}  // namespace nightmap
