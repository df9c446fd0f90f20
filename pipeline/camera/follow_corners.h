// SPDX-License-Identifier: Apache-2.0
// Corners of a reduced picture, and where another picture shows them.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "pipeline/camera/refine_corner.h"
#include "pipeline/io/image_io.h"

namespace nightmap {

// Smallest eigenvalue of the gradients, of gray levels in 0 .. 1: less is noise on a bare wall.
constexpr float kMinCorner = 1e-5F;

double Distance_px(const Eigen::Vector2f& a, const Eigen::Vector2f& b);

// The strongest corner of each cell of a gray picture that has one of this strength, row by row.
// Bare walls have none. Source: Shi and Tomasi, Good features to track, 1994.
std::vector<Eigen::Vector2f> Corners(const GrayImage& gray, int cell_px, float least = kMinCorner);

struct FlowSearch {
  int window_px = 15;  // size of the patch
  int num_levels = 4;  // pictures of half the size each above the full one, from which it starts
  int max_steps = 30;  // in each of them
  double min_step_px = 0.01;
};

// The pictures that optical flow compares: the frame's own and coarser ones. Copies share them.
class FlowPyramid {
 public:
  struct Levels;

  FlowPyramid();  // without pictures
  FlowPyramid(const GrayImage& gray, const FlowSearch& search);

  const Levels& AllLevels() const { return *levels_; }
  GrayView Picture() const;  // the full one

 private:
  std::shared_ptr<const Levels> levels_;
};

struct Followed {
  std::vector<Eigen::Vector2f> points;
  std::vector<unsigned char> is_found;
  std::vector<float> differences;  // mean absolute difference of the patches, gray levels
};

// Pyramidal Lucas-Kanade (Bouguet, 2000). `guess`: where the points may be; empty: where they were.
Followed Follow(const FlowPyramid& from,
                const FlowPyramid& to,
                const std::vector<Eigen::Vector2f>& points,
                const FlowSearch& search,
                std::vector<Eigen::Vector2f> guess = {});

}  // namespace nightmap
