// SPDX-License-Identifier: Apache-2.0
// Frames reduced to what the search for moving things needs, so that a whole shard fits in memory.
#pragma once

#include <vector>

#include "pipeline/camera/follow_corners.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

// Gray at about 320 pixels of width, for optical flow; depth at half of that, for surfaces.
struct SmallFrame {
  GrayImage gray;
  DepthImage depth;    // metres: of each block of pixels the median of those measured; 0: none
  GrayImage may_move;  // at the size of depth, 255 where labels say so; empty: no labels
  std::vector<Eigen::Vector2f> corners;  // of gray
  FlowPyramid pyramid;                   // of gray, for optical flow
};

// The cameras of these two, with the distortion of the whole one.
struct SmallCamera {
  int gray_step = 1;   // pixels of the picture along one of gray
  int depth_step = 2;  // and of depth
  Camera gray;
  Camera depth;
  DepthNoise noise;
  std::vector<Eigen::Vector3d> depth_rays;  // with z = 1, of each pixel of depth, row by row
};

SmallCamera Shrink(const RgbdCamera& camera);

// A value of 0 for each pixel of reduced depth.
Image<float> ZerosLike(const DepthImage& depth);

// `images` have the size of the camera. A frame without depth gets a depth picture in which nothing
// is measured. Throws DataError when the mask of what may move has another size. Deterministic.
SmallFrame Shrink(const RgbdImages& images, const SmallCamera& camera);

// A mask of the size of reduced depth at the size of the whole picture.
GrayImage EnlargeDepthMask(const GrayImage& mask, const SmallCamera& small, const Camera& whole);

// The depth under a pixel of the gray picture; 0 where none is measured.
float DepthAt(const SmallFrame& frame, const Eigen::Vector2f& gray_px);

// Whether labels say that what a pixel of the gray picture shows may move.
bool MayMove(const SmallFrame& frame, const Eigen::Vector2f& gray_px);

}  // namespace nightmap
