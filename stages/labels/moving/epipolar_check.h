// SPDX-License-Identifier: Apache-2.0
// The published check of motion (CN108596974A, paragraphs 46 to 66): two pictures tell which points
// leave their epipolar lines, and a labelled region with such points moves. It needs neither depth
// nor poses.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/labels/labelled_regions.h"
#include "stages/labels/moving/small_frame.h"

namespace nightmap {

// Pixels are those of the reduced gray picture.
struct EpipolarOptions {
  int border_px = 8;                // half the window that is followed
  double max_patch_difference = 6;  // mean over 3 x 3 pixels, gray levels
  double ransac_px = 0.3;           // from both epipolar lines; corners are followed to 0.1 .. 0.2
  double ransac_confidence = 0.99;
  double max_epipolar_px = 0.75;  // a point farther from its line moves
  int min_points = 30;            // fewer pairs say nothing
  int min_moving_points = 5;      // in a region that moves; the edge of a still thing may have some
};

// Follows the corners of the previous frame to this one (pyramidal Lucas-Kanade). Drops pairs near
// the border of either picture, and pairs whose 3 x 3 pixels differ much. Fits the fundamental
// matrix to the others, without their distortion, by OpenCV's RANSAC. Returns the points farther
// than max_epipolar_px from their epipolar line, in pixels of the frame's gray picture; nothing
// when there are fewer than min_points pairs, or no matrix. Deterministic in the seed.
//
// Limits of the method:
// - What moves along its epipolar lines is not found: a thing carried the way the camera goes.
// - A camera that stands or only turns has no fundamental matrix of its own: any epipole explains
//   the still points, which thus are not reported, but some also explain a thing that moves. All
//   points of such a thing are found, or some, or none, from frame to frame.
// - Where all but one thing lies on one plane, likewise, that thing may be reported though it
//   stands.
// A larger ransac_confidence finds the largest agreement more surely: fewer points of still things
// in the third case, and fewer of moving ones in the second.
std::optional<std::vector<Eigen::Vector2f>> MovingPoints(const EpipolarOptions& options,
                                                         int window_px,
                                                         const SmallCamera& camera,
                                                         const SmallFrame& previous,
                                                         const SmallFrame& frame,
                                                         std::uint64_t seed);

// The regions among 1 .. num_regions that move: those with min_moving_points of the `points`. (The
// publication says "some".) `regions` has the size of reduced depth, and 0 where there is none; the
// points are in pixels of gray.
std::vector<bool> RegionsThatMove(const EpipolarOptions& options,
                                  const Image<std::int32_t>& regions,
                                  int num_regions,
                                  const std::vector<Eigen::Vector2f>& points);

// The method's decision on each pixel of reduced depth: 1 in a region that moves and at points that
// move elsewhere, else -1. Labels decide without a previous frame, or when it says nothing.
Image<float> PublishedDecision(const EpipolarOptions& options,
                               int window_px,
                               const SmallCamera& camera,
                               const SmallFrame* previous,
                               const SmallFrame& frame,
                               const LabelledRegions& regions,
                               std::uint64_t seed);

}  // namespace nightmap
