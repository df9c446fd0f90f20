// SPDX-License-Identifier: Apache-2.0
#include "pipeline/features/harris_corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

namespace nightmap {
namespace {

constexpr int kColumns = 8, kRows = 6;
constexpr int kBlock_px = 3;
constexpr double kHarrisK = 0.04;
constexpr int kMaximumRadius_px = 3;    // a corner is the strongest pixel of this square
constexpr int kRefineRadius_px = 4;     // of the window whose gradients place a corner
constexpr float kMaxRefinement_px = 2;  // a longer way leads to another corner
constexpr double kBlur_px = 0.8;        // edges sharper than pixels would pull corners to pixels
constexpr int kPatchRadius_px = 15;     // of ORB's disc

// Response of a corner whose gradients have this root mean square along every direction.
// cornerHarris sums over the block, and scales gradients by 2 / (255 block).
float ResponseOf(double gradient) {
  const double eigenvalue = std::pow(2 * gradient / 255, 2);
  return static_cast<float>(eigenvalue * eigenvalue * (1 - 4 * kHarrisK));
}

struct Peak {
  float response;
  int x, y;
  int Cell(const cv::Mat& image) const {
    return y * kRows / image.rows * kColumns + x * kColumns / image.cols;
  }
};

// The local maxima above a response, strongest first, at most so many of each cell.
std::vector<Peak> FindPeaks(const cv::Mat& image, float min_response, int max_per_cell) {
  cv::Mat response, highest;
  cv::cornerHarris(image, response, kBlock_px, 3, kHarrisK);
  const int size_px = 2 * kMaximumRadius_px + 1;
  cv::dilate(response, highest, cv::Mat::ones(size_px, size_px, CV_8U));
  std::vector<Peak> peaks;
  for (int y = kHarrisBorder_px; y < image.rows - kHarrisBorder_px; ++y) {
    const float* value = response.ptr<float>(y);
    const float* maximum = highest.ptr<float>(y);
    for (int x = kHarrisBorder_px; x < image.cols - kHarrisBorder_px; ++x) {
      if (value[x] >= min_response && value[x] == maximum[x]) peaks.push_back({value[x], x, y});
    }
  }
  std::ranges::sort(peaks, [](const Peak& a, const Peak& b) {
    return std::tie(b.response, a.y, a.x) < std::tie(a.response, b.y, b.x);
  });
  std::array<int, static_cast<std::size_t>(kColumns * kRows)> num_of_cell{};
  std::erase_if(peaks, [&](const Peak& peak) {
    return ++num_of_cell[static_cast<std::size_t>(peak.Cell(image))] > max_per_cell;
  });
  return peaks;
}

// Half the width of the disc of radius kPatchRadius_px in each of its rows from the middle one on.
std::array<int, kPatchRadius_px + 1> HalfWidths() {
  std::array<int, kPatchRadius_px + 1> widths{};
  for (int v = 0; v <= kPatchRadius_px; ++v) {
    widths[static_cast<std::size_t>(v)] =
        static_cast<int>(std::lround(std::sqrt(kPatchRadius_px * kPatchRadius_px - v * v)));
  }
  return widths;
}

float CentroidAngle_deg(const cv::Mat& image, const cv::Point2f& pixel) {
  static const auto kHalfWidths = HalfWidths();
  const int x = cvRound(pixel.x), y = cvRound(pixel.y);
  int moment_x = 0, moment_y = 0;
  for (int v = -kPatchRadius_px; v <= kPatchRadius_px; ++v) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y + v) + x;
    const int half_width = kHalfWidths[static_cast<std::size_t>(std::abs(v))];
    int sum = 0;
    for (int u = -half_width; u <= half_width; ++u) {
      moment_x += u * row[u];
      sum += row[u];
    }
    moment_y += v * sum;
  }
  return cv::fastAtan2(static_cast<float>(moment_y), static_cast<float>(moment_x));
}

}  // namespace

std::vector<HarrisCorner> FindHarrisCorners(const GrayImage& gray, const HarrisOptions& options) {
  constexpr int kSmallest_px = 2 * kHarrisBorder_px + 1;
  if (gray.width < kSmallest_px || gray.height < kSmallest_px) return {};
  const cv::Mat image(
      gray.height, gray.width, CV_8UC1, const_cast<std::uint8_t*>(gray.pixels.data()));
  cv::Mat blurred;
  cv::GaussianBlur(image, blurred, {5, 5}, kBlur_px);
  const auto peaks = FindPeaks(blurred, ResponseOf(options.min_gradient), options.max_per_cell);
  if (peaks.empty()) return {};
  std::vector<cv::Point2f> pixels;
  for (const Peak& peak : peaks) {
    pixels.emplace_back(static_cast<float>(peak.x), static_cast<float>(peak.y));
  }
  cv::cornerSubPix(blurred,
                   pixels,
                   {kRefineRadius_px, kRefineRadius_px},
                   {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01});
  std::vector<HarrisCorner> corners;
  for (std::size_t i = 0; i < peaks.size(); ++i) {
    const cv::Point2f moved = pixels[i] - cv::Point2f(cv::Point(peaks[i].x, peaks[i].y));
    if (std::max(std::abs(moved.x), std::abs(moved.y)) > kMaxRefinement_px) continue;
    corners.push_back(
        {{pixels[i].x, pixels[i].y}, peaks[i].response, CentroidAngle_deg(image, pixels[i])});
  }
  return corners;
}

}  // namespace nightmap
