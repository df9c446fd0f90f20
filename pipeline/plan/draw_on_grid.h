// SPDX-License-Identifier: Apache-2.0
// A picture of a grid, on which paths and robots are drawn.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

using Rgb = std::array<std::uint8_t, 3>;

// White free, black occupied, grey unknown; y up. Drawings beyond the border are clipped. A copy is
// an independent picture. Deterministic.
class GridCanvas {
 public:
  // The grid must outlive the canvas. `pixels_per_cell` may be any positive number: a pixel that
  // covers several cells shows an obstacle if one of them is. Without `is_smooth` lines and discs
  // have only the colors that they are drawn with.
  GridCanvas(const OccupancyGrid& grid, double pixels_per_cell, bool is_smooth);

  void Line(const Eigen::Vector2d& from_in_map,
            const Eigen::Vector2d& to_in_map,
            const Rgb& color,
            int thickness_px = 1);
  // The outline of a rectangle about the origin of its own frame.
  void Rectangle(const Rigid2& map_from_rectangle,
                 const Eigen::Vector2d& size_m,
                 const Rgb& color,
                 int thickness_px = 1);
  void Disc(const Eigen::Vector2d& center_in_map, double radius_px, const Rgb& color);
  void Ring(const Eigen::Vector2d& center_in_map, double radius_px, const Rgb& color);
  // Draws discs around all points, but only on white pixels, so that they hide nothing.
  void Tint(const std::vector<Eigen::Vector2d>& centers_in_map, double radius_px, const Rgb& color);
  // Draws a text to the upper right of a point, moved so that all of it is in the picture. A white
  // rim makes it legible on any background.
  void Label(const Eigen::Vector2d& point_in_map,
             int right_px,
             int above_px,
             const std::string& text,
             const Rgb& color);
  // Draws a bar in the lower left corner: the longest of 1, 2, 5, 10, 20, 50 m that takes at most a
  // quarter of the width.
  void ScaleBar(const Rgb& color);

  double ToPixels(double length_m) const;
  const ColorImage& Picture() const { return image_; }

 private:
  int CellAt(int x, int y) const;
  // The image's pixel (x, y) is the square from (x - 0.5, y - 0.5) on, y down.
  Eigen::Vector2d ToPixel(const Eigen::Vector2d& point_in_map) const;
  void Write(const std::string& text, int x, int y, const Rgb& color);

  const OccupancyGrid& grid_;
  double scale_;  // pixels per cell
  int line_type_;
  ColorImage image_;
};

}  // namespace nightmap
