// SPDX-License-Identifier: Apache-2.0
// Drawing primitives of the procedural textures, on a square that wraps around at its borders.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/io/image_io.h"

namespace nightmap {

class Canvas {
 public:
  Canvas(int size_px, const Eigen::Vector3f& color);

  int Size() const { return size_px_; }
  Eigen::Vector3f& At(int x, int y);  // wraps around

  // Coordinates and lengths below are fractions of the canvas. Edges are anti-aliased.
  // An ellipse (sharpness 2) to nearly a rectangle (sharpness 8), rotated by an angle.
  void Blob(const Eigen::Vector2f& center,
            const Eigen::Vector2f& radii,
            float angle_rad,
            float sharpness,
            const Eigen::Vector3f& color,
            float opacity = 1.0F);
  void Rectangle(const Eigen::Vector2f& low,
                 const Eigen::Vector2f& high,
                 const Eigen::Vector3f& color);
  // A line of random 4x6 letters as high as `height`.
  void Glyphs(const Eigen::Vector2f& low,
              float width,
              float height,
              const Eigen::Vector3f& color,
              Random& random);
  // Multiplies by 1 + amplitude * (noise - 0.5) * 2, with `octaves` of doubling frequency from
  // `cells_x`, `cells_y` lattice cells.
  void MultiplyNoise(float amplitude, int cells_x, int cells_y, int octaves, std::uint64_t seed);

  ColorImage ToImage() const;

 private:
  int size_px_;
  std::vector<Eigen::Vector3f> pixels_;
};

// Saturated random color between the two brightness bounds [0, 255].
Eigen::Vector3f RandomColor(Random& random, float darkest, float brightest);

}  // namespace nightmap
