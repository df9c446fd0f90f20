// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/follow_corners.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>

namespace nightmap {
namespace {

constexpr int kNumFlowLevels = 4;  // above the reduced size

cv::Mat ViewOf(const GrayImage& image) {
  // OpenCV takes no const pixels; nothing here writes them.
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())};
}

}  // namespace

std::vector<cv::Point2f> Corners(const GrayImage& gray, int cell_px, float least) {
  cv::Mat strength;
  cv::cornerMinEigenVal(ViewOf(gray), strength, 3);
  std::vector<cv::Point2f> corners;
  for (int top = 0; top < gray.height; top += cell_px) {
    for (int left = 0; left < gray.width; left += cell_px) {
      const cv::Rect cell =
          cv::Rect(left, top, cell_px, cell_px) & cv::Rect(0, 0, gray.width, gray.height);
      double best = 0;
      cv::Point at;
      cv::minMaxLoc(strength(cell), nullptr, &best, nullptr, &at);
      if (best > least) corners.emplace_back(at + cell.tl());
    }
  }
  return corners;
}

std::vector<cv::Mat> FlowPyramid(const GrayImage& gray, int window_px) {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(
      ViewOf(gray), pyramid, {window_px, window_px}, kNumFlowLevels, /*withDerivatives=*/false);
  return pyramid;
}

Followed Follow(const std::vector<cv::Mat>& from,
                const std::vector<cv::Mat>& to,
                const std::vector<cv::Point2f>& points,
                int window_px,
                std::vector<cv::Point2f> guess) {
  Followed followed{std::move(guess), {}, {}};
  const bool has_guess = !followed.points.empty();
  cv::calcOpticalFlowPyrLK(
      from,
      to,
      points,
      followed.points,
      followed.is_found,
      followed.differences,
      {window_px, window_px},
      has_guess ? 2 : kNumFlowLevels,
      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01),
      has_guess ? cv::OPTFLOW_USE_INITIAL_FLOW : 0);
  return followed;
}

}  // namespace nightmap
