// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/survey/frame_measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "pipeline/base/median.h"
#include "pipeline/camera/follow_corners.h"

namespace nightmap {
namespace {

constexpr int kCell_px = 16;
constexpr float kClearCorner = 10 * kMinCorner;  // three times the contrast of noise
constexpr double kFineSigma_px = 1;
constexpr double kCoarseSigma_px = 2.5;
constexpr double kEdgeShare = 0.01;  // of the pixels, the strongest
constexpr float kMinGradient = 3;    // gray levels per pixel: less is noise and soft shading
constexpr int kMinEdgePixels = 50;

struct Gradient {
  cv::Mat x, y;
};

Gradient GradientOf(const cv::Mat& gray, double sigma_px) {
  cv::Mat smooth;
  Gradient gradient;
  cv::GaussianBlur(gray, smooth, {0, 0}, sigma_px);
  cv::Sobel(smooth, gradient.x, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(smooth, gradient.y, CV_32F, 0, 1, 3, 1.0 / 8);
  return gradient;
}

// A step blurred by sigma has, blurred once more by s, the slope 1 / sqrt(sigma^2 + s^2).
double SigmaOf(double ratio) {
  constexpr double kFine = kFineSigma_px * kFineSigma_px;
  constexpr double kCoarse = kCoarseSigma_px * kCoarseSigma_px;
  const double squared = ratio * ratio;
  if (squared <= 1.0001) return 2 * kCoarseSigma_px;  // no longer measurable
  return std::sqrt(std::max(0.0, (kCoarse - squared * kFine) / (squared - 1)));
}

// The strength that kEdgeShare of the pixels have. Some of them tell.
float Strongest(const cv::Mat& strengths) {
  constexpr std::size_t kStep = 7;
  std::vector<float> some;
  const std::size_t count = strengths.total();  // of one piece of memory
  for (std::size_t i = 0; i < count; i += kStep) some.push_back(strengths.ptr<float>()[i]);
  const auto nth = some.begin() +
                   static_cast<std::ptrdiff_t>((1 - kEdgeShare) * static_cast<double>(some.size()));
  std::nth_element(some.begin(), nth, some.end());
  return some.empty() ? 0 : *nth;
}

// Blur of the strongest edges across a direction; 0 if there are too few.
double BlurAlong(const Gradient& fine, const Gradient& coarse, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const cv::Mat along_fine = cv::abs(c * fine.x + s * fine.y);
  const cv::Mat along_coarse = cv::abs(c * coarse.x + s * coarse.y);
  const float least = std::max(Strongest(along_coarse), kMinGradient);
  std::vector<double> ratios;
  for (int y = 0; y < along_coarse.rows; ++y) {
    const auto* of_coarse = along_coarse.ptr<float>(y);
    const auto* of_fine = along_fine.ptr<float>(y);
    for (int x = 0; x < along_coarse.cols; ++x) {
      if (of_coarse[x] >= least) ratios.push_back(of_fine[x] / of_coarse[x]);
    }
  }
  return static_cast<int>(ratios.size()) < kMinEdgePixels ? 0 : SigmaOf(Median(std::move(ratios)));
}

void MeasureExposure(const GrayImage& gray, FrameMeasures* measures) {
  double sum = 0;
  std::size_t num_dark = 0, num_bright = 0;
  for (const std::uint8_t level : gray.pixels) {
    sum += level;
    if (level < 8) ++num_dark;
    if (level > 247) ++num_bright;
  }
  const auto count = static_cast<double>(gray.pixels.size());
  measures->brightness = sum / count;
  measures->dark_share = static_cast<double>(num_dark) / count;
  measures->bright_share = static_cast<double>(num_bright) / count;
}

void MeasureDepth(const DepthImage& depth, FrameMeasures* measures) {
  std::vector<float> measured;
  for (std::size_t i = 0; i < depth.pixels.size(); i += 3) {
    if (depth.pixels[i] > 0) measured.push_back(depth.pixels[i]);
  }
  if (measured.empty()) return;
  measures->measured_share = static_cast<double>(measured.size()) /
                             std::ceil(static_cast<double>(depth.pixels.size()) / 3);
  const auto quantile = [&](double share) {
    const auto nth = measured.begin() +
                     static_cast<std::ptrdiff_t>(share * static_cast<double>(measured.size() - 1));
    std::nth_element(measured.begin(), nth, measured.end());
    return static_cast<double>(*nth);
  };
  measures->depth_p10_m = quantile(0.1);
  measures->depth_median_m = quantile(0.5);
  measures->depth_p90_m = quantile(0.9);
}

}  // namespace

double BlurOf(const GrayImage& gray) {
  constexpr double kPi = 3.14159265358979;
  const cv::Mat pixels(
      gray.height, gray.width, CV_8UC1, const_cast<std::uint8_t*>(gray.pixels.data()));
  cv::Mat levels;  // 8 bits would round weak slopes
  pixels.convertTo(levels, CV_32F);
  const Gradient fine = GradientOf(levels, kFineSigma_px);
  const Gradient coarse = GradientOf(levels, kCoarseSigma_px);
  std::array<double, 4> along{};
  for (std::size_t i = 0; i < 4; ++i) {
    along[i] = BlurAlong(fine, coarse, static_cast<double>(i) * kPi / 4);
  }
  std::ranges::sort(along);
  return along[2];
}

FrameMeasures MeasureFrame(const GrayImage& gray, const GrayImage& small, const DepthImage& depth) {
  FrameMeasures measures;
  MeasureExposure(gray, &measures);
  measures.blur_px = BlurOf(gray);
  const int num_cells = std::max(1, (small.width / kCell_px) * (small.height / kCell_px));
  measures.textured_share =
      std::min(1.0, static_cast<double>(Corners(small, kCell_px, kClearCorner).size()) / num_cells);
  MeasureDepth(depth, &measures);
  return measures;
}

}  // namespace nightmap
