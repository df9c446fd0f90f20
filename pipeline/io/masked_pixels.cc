// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/masked_pixels.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

constexpr float kMidGray = 128;

template <typename T>
void CheckSize(const GrayImage& mask, const Image<T>& image) {
  if (mask.width == image.width && mask.height == image.height) return;
  throw DataError("the mask is {} x {} pixels and its picture {} x {}",
                  mask.width,
                  mask.height,
                  image.width,
                  image.height);
}

// Colors times weights, and the weights: 1 where nothing is masked.
struct Weighted {
  cv::Mat colors;   // CV_32FC3
  cv::Mat weights;  // CV_32FC1
};

Weighted Halved(const Weighted& fine) {
  const cv::Size size((fine.weights.cols + 1) / 2, (fine.weights.rows + 1) / 2);
  Weighted coarse;
  cv::resize(fine.colors, coarse.colors, size, 0, 0, cv::INTER_AREA);
  cv::resize(fine.weights, coarse.weights, size, 0, 0, cv::INTER_AREA);
  return coarse;
}

// The picture at one scale: what is not masked, and elsewhere the coarser picture.
cv::Mat Filled(const Weighted& level) {
  cv::Mat coarse;
  if (level.weights.total() == 1) {
    coarse = cv::Mat(1, 1, CV_32FC3, cv::Scalar::all(kMidGray));
  } else {
    cv::resize(Filled(Halved(level)), coarse, level.weights.size(), 0, 0, cv::INTER_LINEAR);
  }
  cv::Mat filled(level.weights.size(), CV_32FC3);
  for (int y = 0; y < filled.rows; ++y) {
    for (int x = 0; x < filled.cols; ++x) {
      const float missing = 1 - level.weights.at<float>(y, x);
      filled.at<cv::Vec3f>(y, x) =
          level.colors.at<cv::Vec3f>(y, x) + missing * coarse.at<cv::Vec3f>(y, x);
    }
  }
  return filled;
}

Weighted Unmasked(const GrayImage& mask, const ColorImage& color) {
  Weighted level{cv::Mat::zeros(color.height, color.width, CV_32FC3),
                 cv::Mat::zeros(color.height, color.width, CV_32FC1)};
  for (int y = 0; y < color.height; ++y) {
    for (int x = 0; x < color.width; ++x) {
      if (mask.At(x, y) != 0) continue;
      level.weights.at<float>(y, x) = 1;
      level.colors.at<cv::Vec3f>(y, x) = {static_cast<float>(color.At(x, y, 0)),
                                          static_cast<float>(color.At(x, y, 1)),
                                          static_cast<float>(color.At(x, y, 2))};
    }
  }
  return level;
}

}  // namespace

bool IsMasked(const GrayImage& mask, const Eigen::Vector2d& pixel) {
  const auto x = static_cast<int>(std::lround(pixel.x()));
  const auto y = static_cast<int>(std::lround(pixel.y()));
  return x >= 0 && y >= 0 && x < mask.width && y < mask.height && mask.At(x, y) != 0;
}

bool IsAnyMasked(const GrayImage& mask) {
  return std::ranges::any_of(mask.pixels, [](std::uint8_t value) { return value > 0; });
}

void FadeOut(const GrayImage& mask, ColorImage* color) {
  CheckSize(mask, *color);
  if (!IsAnyMasked(mask)) return;
  const cv::Mat filled = Filled(Unmasked(mask, *color));
  for (int y = 0; y < color->height; ++y) {
    for (int x = 0; x < color->width; ++x) {
      if (mask.At(x, y) == 0) continue;
      for (int channel = 0; channel < 3; ++channel) {
        color->At(x, y, channel) =
            cv::saturate_cast<std::uint8_t>(filled.at<cv::Vec3f>(y, x)[channel]);
      }
    }
  }
}

void RemoveDepth(const GrayImage& mask, DepthImage* depth) {
  CheckSize(mask, *depth);
  for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
    if (mask.pixels[i] != 0) depth->pixels[i] = 0;
  }
}

}  // namespace nightmap
