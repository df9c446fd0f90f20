// SPDX-License-Identifier: Apache-2.0
// Casts rays through the rectangles of a CeilingPlan.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "stages/ceiling/synthesize_ceiling/ceiling_plan.h"

namespace nightmap {

// Faces of a rectangle: its sides at x0, x1, y0 and y1, seen from inside, then its ceiling.
inline constexpr int kCeilingFace = 4;
inline constexpr int kNumFaces = 5;

// Where a ray ends. rect < 0: nowhere, because it leads down or begins outside.
struct CeilingHit {
  int rect = -1;
  int face = kCeilingFace;
  double t = 0;                                  // point = origin + t * direction
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  // on the face: metres along it from the corner at
                                                 // x0 or y0, and height; ceiling: x - x0, y - y0

  int FaceIdx() const { return rect * kNumFaces + face; }
};

// Within a rectangle, a ray reaches the ceiling or goes out through a side. There it continues in
// the neighbour if it is below the neighbour's ceiling; else it hits the side: a wall, or the face
// of a beam or lintel. Thread safe.
class CeilingWalk {
 public:
  explicit CeilingWalk(const CeilingPlan& plan);

  // A ray from a point within rectangle `rect`, below its ceiling.
  CeilingHit Cast(int rect, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

 private:
  struct Neighbour {
    int rect = 0;
    double begin_m = 0, end_m = 0;  // x or y along the side, in the building frame
  };
  struct Cell {
    Rect2 area;
    double height_m = 0;
    std::array<std::vector<Neighbour>, 4> neighbours;
  };
  int NeighbourAt(const Cell& cell, int side, double along_m, double height_m) const;

  std::vector<Cell> cells_;
};

}  // namespace nightmap
