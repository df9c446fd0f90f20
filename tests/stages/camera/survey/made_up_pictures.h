// SPDX-License-Identifier: Apache-2.0
// Pictures of the survey's tests, with depth.
#pragma once

#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/io/image_io.h"

namespace nightmap::survey_test {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// Bright and dark squares of random size: sharp edges in every place, at several angles.
inline GrayImage Blocks(int width, int height, std::uint64_t seed) {
  Random random(seed, 0);
  GrayImage picture{
      width, height, 1, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height), 100)};
  cv::Mat view(height, width, CV_8UC1, picture.pixels.data());
  for (int i = 0; i < 120; ++i) {
    const cv::Point2f center(static_cast<float>(random.Uniform(0, width)),
                             static_cast<float>(random.Uniform(0, height)));
    const cv::RotatedRect block(
        center,
        {static_cast<float>(random.Uniform(10, 60)), static_cast<float>(random.Uniform(10, 60))},
        static_cast<float>(random.Uniform(0, 180)));
    cv::Point2f corners[4];
    block.points(corners);
    std::vector<cv::Point> polygon(corners, corners + 4);
    cv::fillConvexPoly(view, polygon, cv::Scalar(random.Uniform(20, 235)), cv::LINE_AA);
  }
  return picture;
}

// Boards before a far wall, seen by a camera that turns. Frame i of depth may be that of another.
struct Turning {
  GrayImage scene = Blocks(2 * kWidth, kHeight, 7);

  GrayImage Color(int frame) const { return Window(scene, frame); }
  DepthImage Depth(int frame, int shift_px = 0) const {
    const GrayImage gray = Window(scene, frame, shift_px);
    DepthImage depth{kWidth, kHeight, 1, {}};
    for (const std::uint8_t level : gray.pixels) depth.pixels.push_back(1.0F + 0.02F * level);
    return depth;
  }
  static GrayImage Window(const GrayImage& whole, int frame, int shift_px = 0) {
    GrayImage part{kWidth, kHeight, 1, {}};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x)
        part.pixels.push_back(whole.At(x + 5 * frame + 40 + shift_px, y));
    }
    return part;
  }
};

inline ColorImage ToColor(const GrayImage& gray) {
  ColorImage color{gray.width, gray.height, 3, {}};
  for (const std::uint8_t level : gray.pixels) color.pixels.insert(color.pixels.end(), 3, level);
  return color;
}

}  // namespace nightmap::survey_test
