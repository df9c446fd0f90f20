// SPDX-License-Identifier: Apache-2.0
// A gray picture of one face of the building, to scale, with a pyramid of means.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/world/scene.h"

namespace nightmap {

// Places are metres from the corner of the face. All edges are drawn anti-aliased, so that they lie
// where they are to a small part of a cell. Brightness is linear: 0 is black; from 255 on a picture
// of gain 1 saturates.
class CeilingRaster {
 public:
  CeilingRaster() = default;
  CeilingRaster(double width_m, double height_m, double cell_m, float brightness);

  // Drawing; opacity 1 covers what is below.
  void Box(const Rect2& area, float brightness, float opacity = 1);
  void Disc(const Eigen::Vector2d& center, double radius_m, float brightness, float opacity = 1);
  // Multiplies by 1 + amplitude * noise in [-1, 1], smooth over `cell_m`.
  void MultiplyNoise(float amplitude, double cell_m, std::uint64_t seed);

  // After the last drawing and before the first Sample: makes the pyramid.
  void Finish();
  // Brightness at a place, averaged over about `footprint_m` (trilinear); beyond the borders that
  // of the border.
  float Sample(double x_m, double y_m, double footprint_m) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<float> values;
    float& At(int x, int y) {
      return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(x)];
    }
    float At(int x, int y) const { return const_cast<Level*>(this)->At(x, y); }
    float Bilinear(float x, float y) const;
  };
  static Level Halve(const Level& fine);

  double cell_m_ = 1;
  double cells_per_m_ = 1;
  std::vector<Level> levels_;
};

}  // namespace nightmap
