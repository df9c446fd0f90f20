// SPDX-License-Identifier: Apache-2.0
// Corners of a reduced picture, and where another picture shows them.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

// Smallest eigenvalue of the gradients, of gray levels in 0 .. 1: less is noise on a bare wall.
constexpr float kMinCorner = 1e-5F;

// The strongest corner of each cell of a gray picture that has one of this strength, row by row.
// Bare walls have none. Source: Shi and Tomasi, Good features to track, 1994.
std::vector<cv::Point2f> Corners(const GrayImage& gray, int cell_px, float least = kMinCorner);

// The pictures that optical flow compares: the frame's own and coarser ones.
std::vector<cv::Mat> FlowPyramid(const GrayImage& gray, int window_px);

struct Followed {
  std::vector<cv::Point2f> points;
  std::vector<unsigned char> is_found;
  std::vector<float> differences;  // mean absolute difference of the patches, gray levels
};

// Pyramidal Lucas-Kanade (Bouguet, 2000). `guess`: where the points may be; empty: where they were.
Followed Follow(const std::vector<cv::Mat>& from,
                const std::vector<cv::Mat>& to,
                const std::vector<cv::Point2f>& points,
                int window_px,
                std::vector<cv::Point2f> guess = {});

}  // namespace nightmap
