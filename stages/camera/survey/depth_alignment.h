// SPDX-License-Identifier: Apache-2.0
// Whether depth pictures lie on the color pictures that they belong to: edges of depth are edges of
// color, in the same frame and at the same pixel.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

constexpr int kMaxFrameOffset = 4;
constexpr std::size_t kMaxEdgePixels = 1500;

struct Pixel {
  int x = 0;
  int y = 0;
};

// Edges of a frame's depth and of colors.
struct FrameEdges {
  Image<float> strengths;  // of color at reduced pixels, in multiples of their mean
  // Reduced pixels at the near side of steps in depth, at most kMaxEdgePixels evenly spread ones.
  std::vector<Pixel> at;
};

// Alignment of a window of consecutive frames: the mean strength of the color at edges of depth. 1:
// no more than anywhere else.
struct DepthAlignment {
  std::size_t first_frame = 0;
  std::size_t num_edges = 0;  // pixels
  // Colors of the frame -kMaxFrameOffset .. kMaxFrameOffset after the depth, at the same pixel.
  std::array<double, 2 * kMaxFrameOffset + 1> by_frame_offset{};
  std::vector<double> by_shift;  // colors of the same frame, at the pixels of each of Shifts()
};

// Shifts of depth against color, in pixels reduced to about 320 of width: a grid that has (0, 0).
const std::vector<Pixel>& Shifts();

// The shift at which color and depth agree best over all windows, each weighted by its edges.
struct BestShift {
  Pixel shift;
  std::vector<double> at_best;  // per window
  std::vector<double> at_zero;
};
BestShift FindBestShift(const std::vector<DepthAlignment>& windows);

// `small`: gray reduced to about 320 pixels of width; depth in metres, of any size, at the same
// rays; without pixels: no edges.
FrameEdges EdgesOf(const GrayImage& small, const DepthImage& depth);

// `frames` are in succession, of one size. Without edges num_edges is 0 and by_shift empty.
// Deterministic.
DepthAlignment MeasureAlignment(const std::vector<FrameEdges>& frames);

}  // namespace nightmap
