// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/harris_corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "pipeline/camera/refine_corner.h"

namespace nightmap {
namespace {

constexpr int kColumns = 8, kRows = 6;
constexpr double kHarrisK = 0.04;
constexpr int kMaximumRadius_px = 3;     // a corner is the strongest pixel of this square
constexpr int kRefineRadius_px = 4;      // of the window whose gradients place a corner
constexpr double kMaxRefinement_px = 3;  // the maximum lies this far inside of a sharp angle
constexpr float kSameCorner_px = 3;      // maxima that lead to points this near are one corner
constexpr double kBlur_px = 0.8;         // edges sharper than pixels would pull corners to pixels
constexpr int kPatchRadius_px = 15;      // of ORB's disc

// Response of a corner whose gradients have this root mean square along every direction.
float ResponseOf(double gradient) {
  return static_cast<float>(std::pow(gradient, 4) * (1 - 4 * kHarrisK));
}

// Products of gradients along one row, in (gray levels / px)^2.
struct ProductRow {
  std::vector<float> xx, xy, yy;
  explicit ProductRow(int width)
      : xx(static_cast<std::size_t>(width)), xy(xx.size()), yy(xx.size()) {}

  void Load(const cv::Mat& image, int y) {
    const std::uint8_t *row = image.ptr(y), *above = image.ptr(y - 1), *below = image.ptr(y + 1);
    for (int x = 1; x < image.cols - 1; ++x) {
      const float gx = 0.5F * static_cast<float>(row[x + 1] - row[x - 1]);
      const float gy = 0.5F * static_cast<float>(below[x] - above[x]);
      xx.data()[x] = gx * gx;
      xy.data()[x] = gx * gy;
      yy.data()[x] = gy * gy;
    }
  }
};

// det - k trace^2 of the mean structure tensor of 3 x 3 pixels; 0 at the border. The same as
// cv::cornerHarris, without writing each step to memory as a picture.
cv::Mat HarrisResponse(const cv::Mat& image) {
  cv::Mat response = cv::Mat::zeros(image.size(), CV_32F);
  std::array<ProductRow, 3> rows{
      ProductRow(image.cols), ProductRow(image.cols), ProductRow(image.cols)};
  ProductRow sum(image.cols);
  for (int y = 1; y < image.rows - 1; ++y) {
    rows[static_cast<std::size_t>(y % 3)].Load(image, y);
    if (y < 3) continue;
    const auto& [a, b, c] = rows;
    for (std::size_t x = 0; x < sum.xx.size(); ++x) sum.xx[x] = a.xx[x] + b.xx[x] + c.xx[x];
    for (std::size_t x = 0; x < sum.xx.size(); ++x) sum.xy[x] = a.xy[x] + b.xy[x] + c.xy[x];
    for (std::size_t x = 0; x < sum.xx.size(); ++x) sum.yy[x] = a.yy[x] + b.yy[x] + c.yy[x];
    float* out = response.ptr<float>(y - 1);
    const float *xx = sum.xx.data(), *xy = sum.xy.data(), *yy = sum.yy.data();
    for (int x = 2; x < image.cols - 2; ++x) {
      const float m_xx = (xx[x - 1] + xx[x] + xx[x + 1]) / 9;
      const float m_xy = (xy[x - 1] + xy[x] + xy[x + 1]) / 9;
      const float m_yy = (yy[x - 1] + yy[x] + yy[x + 1]) / 9;
      const float trace = m_xx + m_yy;
      out[x] = m_xx * m_yy - m_xy * m_xy - static_cast<float>(kHarrisK) * trace * trace;
    }
  }
  return response;
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
  const cv::Mat response = HarrisResponse(image);
  cv::Mat highest;
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

float CentroidAngle_deg(const cv::Mat& image, const Eigen::Vector2f& pixel) {
  static const auto half_widths = HalfWidths();
  const int x = cvRound(pixel.x()), y = cvRound(pixel.y());
  int moment_x = 0, moment_y = 0;
  for (int v = -kPatchRadius_px; v <= kPatchRadius_px; ++v) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(y + v) + x;
    const int half_width = half_widths[static_cast<std::size_t>(std::abs(v))];
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
  const GrayView view{
      blurred.ptr(), blurred.cols, blurred.rows, static_cast<std::ptrdiff_t>(blurred.step)};
  std::vector<HarrisCorner> corners;
  for (const Peak& peak : peaks) {
    const Eigen::Vector2f start(static_cast<float>(peak.x), static_cast<float>(peak.y));
    const auto pixel = RefineCorner(view, start, kRefineRadius_px, kMaxRefinement_px);
    const auto is_same = [&](const HarrisCorner& stronger) {
      return (stronger.pixel - *pixel).squaredNorm() < kSameCorner_px * kSameCorner_px;
    };
    if (!pixel || std::ranges::any_of(corners, is_same)) continue;
    corners.push_back({*pixel, peak.response, CentroidAngle_deg(image, *pixel)});
  }
  return corners;
}

}  // namespace nightmap
