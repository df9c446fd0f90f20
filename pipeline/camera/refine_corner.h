// SPDX-License-Identifier: Apache-2.0
// Puts a corner where the gradients around it aim: the point q to which every edge near it leads,
// sum w g g^T (p - q) = 0 over the pixels p with gradients g (Foerstner and Guelch, A fast operator
// for detection and precise location of distinct points, 1987). cv::cornerSubPix solves the same
// but interpolates the window anew in each iteration, and puts a corner that it loses back where it
// was. Here only the weights move, and nothing is returned where there is no corner.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace nightmap {

// Gray pixels of somebody else, row after row.
struct GrayView {
  const std::uint8_t* pixels = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t row_size = 0;  // from row to row
};

constexpr int kMaxRefineRadius_px = 15;

// The corner near `start`, to which the pixels at most radius_px away along x and y contribute,
// those in the middle most. Nothing when there is none within max_move_px, or the window reaches
// over the border. Deterministic.
std::optional<Eigen::Vector2f> RefineCorner(const GrayView& gray,
                                            const Eigen::Vector2f& start,
                                            int radius_px,
                                            double max_move_px);

}  // namespace nightmap
