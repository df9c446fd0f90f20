// SPDX-License-Identifier: Apache-2.0
// Corners of a reduced picture, and where another picture shows them.
#pragma once

#include <memory>
#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

// Smallest eigenvalue of the gradients, of gray levels in 0 .. 1: less is noise on a bare wall.
constexpr float kMinCorner = 1e-5F;

// A place in a gray picture, pixels.
struct GrayPoint {
  float x = 0;
  float y = 0;

  bool operator==(const GrayPoint&) const = default;
};

double Distance_px(const GrayPoint& a, const GrayPoint& b);

// The strongest corner of each cell of a gray picture that has one of this strength, row by row.
// Bare walls have none. Source: Shi and Tomasi, Good features to track, 1994.
std::vector<GrayPoint> Corners(const GrayImage& gray, int cell_px, float least = kMinCorner);

// The pictures that optical flow compares: the frame's own and coarser ones. Copies share them.
class FlowPyramid {
 public:
  struct Levels;

  FlowPyramid();  // without pictures
  FlowPyramid(const GrayImage& gray, int window_px);

  const Levels& AllLevels() const { return *levels_; }

 private:
  std::shared_ptr<const Levels> levels_;
};

struct Followed {
  std::vector<GrayPoint> points;
  std::vector<unsigned char> is_found;
  std::vector<float> differences;  // mean absolute difference of the patches, gray levels
};

// Pyramidal Lucas-Kanade (Bouguet, 2000). `guess`: where the points may be; empty: where they were.
Followed Follow(const FlowPyramid& from,
                const FlowPyramid& to,
                const std::vector<GrayPoint>& points,
                int window_px,
                std::vector<GrayPoint> guess = {});

}  // namespace nightmap
