// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/follow_corners.h"

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

cv::Mat ViewOf(const std::vector<GrayPoint>& points) {
  static_assert(sizeof(GrayPoint) == sizeof(cv::Point2f));
  return {1, static_cast<int>(points.size()), CV_32FC2, const_cast<GrayPoint*>(points.data())};
}

}  // namespace

double Distance_px(const GrayPoint& a, const GrayPoint& b) {
  return cv::norm(cv::Point2f(a.x - b.x, a.y - b.y));
}

std::vector<GrayPoint> Corners(const GrayImage& gray, int cell_px, float least) {
  cv::Mat strength;
  cv::cornerMinEigenVal(ViewOf(gray), strength, 3);
  std::vector<GrayPoint> corners;
  for (int top = 0; top < gray.height; top += cell_px) {
    for (int left = 0; left < gray.width; left += cell_px) {
      const cv::Rect cell =
          cv::Rect(left, top, cell_px, cell_px) & cv::Rect(0, 0, gray.width, gray.height);
      double best = 0;
      cv::Point at;
      cv::minMaxLoc(strength(cell), nullptr, &best, nullptr, &at);
      const cv::Point2f px = at + cell.tl();
      if (best > least) corners.push_back({px.x, px.y});
    }
  }
  return corners;
}

struct FlowPyramid::Levels {
  std::vector<cv::Mat> pictures;
};

FlowPyramid::FlowPyramid() : levels_(std::make_shared<Levels>()) {}

FlowPyramid::FlowPyramid(const GrayImage& gray, int window_px) {
  const auto levels = std::make_shared<Levels>();
  cv::buildOpticalFlowPyramid(ViewOf(gray),
                              levels->pictures,
                              {window_px, window_px},
                              kNumFlowLevels,
                              /*withDerivatives=*/false);
  levels_ = levels;
}

Followed Follow(const FlowPyramid& from,
                const FlowPyramid& to,
                const std::vector<GrayPoint>& points,
                int window_px,
                std::vector<GrayPoint> guess) {
  Followed followed{std::move(guess), {}, {}};
  const bool has_guess = !followed.points.empty();
  followed.points.resize(points.size());
  cv::Mat there = ViewOf(followed.points);
  cv::calcOpticalFlowPyrLK(
      from.AllLevels().pictures,
      to.AllLevels().pictures,
      ViewOf(points),
      there,
      followed.is_found,
      followed.differences,
      {window_px, window_px},
      has_guess ? 2 : kNumFlowLevels,
      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01),
      has_guess ? cv::OPTFLOW_USE_INITIAL_FLOW : 0);
  return followed;
}

}  // namespace nightmap
