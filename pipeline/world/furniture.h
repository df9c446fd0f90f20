// SPDX-License-Identifier: Apache-2.0
// Pieces of furniture made of boxes. A piece has its own frame: x along its wall (to the left, seen
// from the room), y from the wall into the room, z up.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/world/scene_builder.h"

namespace nightmap {

// Pose of a piece: building_from_piece in the plane.
struct Placement {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  double yaw_rad = 0;
  Eigen::Vector2d ToBuilding(const Eigen::Vector2d& point_in_piece) const;
};

// The boxes of one piece, collected before the check whether the piece fits.
class Piece {
 public:
  Piece(const Placement& placement, SceneBuilder& builder)
      : placement_(placement), builder_(&builder) {}

  // Adds a box from corner to corner, rotated about its own vertical axis by `yaw_rad`. The
  // picture, if any, is on the side away from the wall.
  void Add(const Eigen::Vector3d& low,
           const Eigen::Vector3d& high,
           SurfaceLabel label,
           const Material& material,
           double yaw_rad = 0,
           const Material* picture = nullptr);

  // Smallest horizontal distance from the piece to any of the points.
  double Distance(const std::vector<Eigen::Vector2d>& points) const;
  bool Overlaps(const std::vector<Box>& boxes) const;
  void Commit();
  std::vector<Box> Boxes() const;
  SceneBuilder& Builder() { return *builder_; }

 private:
  struct Part {
    Box box;
    Material material;
    Material picture;
    bool has_picture = false;
  };
  Placement placement_;
  SceneBuilder* builder_;
  std::vector<Part> parts_;
};

enum class Furniture { kDesk, kBookshelf, kCabinet, kWardrobe, kBed, kSofa, kTable, kLowShelf };
double FurnitureDepth_m(Furniture kind);

// Adds the parts of a piece `width_m` wide with its origin at the right end of its wall side, seen
// from the room.
void BuildFurniture(Furniture kind, double width_m, Random& random, Piece& piece);

}  // namespace nightmap
