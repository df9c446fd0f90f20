// SPDX-License-Identifier: Apache-2.0
// The surface that a camera sees at each point of its picture, without a ray through every pixel.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/world/scene.h"

namespace nightmap {

// Divides the picture into four until a part shows one surface or is a small tile (Warnock,
// University of Utah TR 4-15, 1969). A tile keeps only the surfaces that it may show.
class VisibleSurfaces {
 public:
  // `camera` must have no distortion.
  VisibleSurfaces(const std::vector<Surface>& surfaces,
                  const Camera& camera,
                  const Rigid3& building_from_camera);

  // The surface that RayScene::Cast hits at a point within half a pixel of the picture. Nothing
  // where an edge or another surface is so near that rounding may decide, and where nothing is
  // seen.
  std::optional<int> At(double x, double y) const;

 private:
  // A surface as seen from the camera. Points of the picture are (x, y, 1) in the plane z = 1.
  struct Outline {
    Eigen::Array4d edge_x, edge_y, edge_1;  // distance from its four edges, positive inside
    Eigen::Vector3d nearness_per_m;         // dot with the point: 1 / depth of its plane
    double tolerance = 0;                   // largest relative error of the nearness
    int surface_idx = -1;
  };
  struct Tile {
    std::size_t first = 0;  // in candidates_
    std::size_t count = 0;
    bool is_covered = false;  // by its only candidate
  };
  // A square of the picture; its points reach half a pixel beyond the outer pixels.
  struct Square {
    int x0 = 0;
    int y0 = 0;
    int size_px = 0;
  };

  static Outline MakeOutline(const Surface& surface,
                             int surface_idx,
                             const Rigid3& camera_from_building);
  Eigen::Vector3d PointAt(double x, double y) const;
  // Leaves out what lies outside the square, or behind a surface that covers it.
  std::vector<int> Prune(const Square& square,
                         std::span<const int> candidates,
                         bool& is_covered) const;
  void Divide(const Square& square, std::span<const int> candidates);
  void Store(const Square& square, std::span<const int> candidates, bool is_covered);

  Camera camera_;
  std::vector<Outline> outlines_;
  int num_columns_ = 0;  // of tiles
  int num_rows_ = 0;
  std::vector<Tile> tiles_;
  std::vector<int> candidates_;  // of all tiles, indices of outlines_
};

}  // namespace nightmap
