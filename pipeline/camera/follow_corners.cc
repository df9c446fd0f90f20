// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/follow_corners.h"

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <utility>

namespace nightmap {
namespace {

cv::Mat ViewOf(const GrayImage& image) {
  // OpenCV takes no const pixels; nothing here writes them.
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())};
}

cv::Mat ViewOf(const std::vector<Eigen::Vector2f>& points) {
  static_assert(sizeof(Eigen::Vector2f) == sizeof(cv::Point2f));
  return {
      1, static_cast<int>(points.size()), CV_32FC2, const_cast<Eigen::Vector2f*>(points.data())};
}

}  // namespace

double Distance_px(const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
  return (a - b).cast<double>().norm();
}

std::vector<Eigen::Vector2f> Corners(const GrayImage& gray, int cell_px, float least) {
  cv::Mat strength;
  cv::cornerMinEigenVal(ViewOf(gray), strength, 3);
  std::vector<Eigen::Vector2f> corners;
  for (int top = 0; top < gray.height; top += cell_px) {
    for (int left = 0; left < gray.width; left += cell_px) {
      const cv::Rect cell =
          cv::Rect(left, top, cell_px, cell_px) & cv::Rect(0, 0, gray.width, gray.height);
      double best = 0;
      cv::Point at;
      cv::minMaxLoc(strength(cell), nullptr, &best, nullptr, &at);
      const cv::Point2f px = at + cell.tl();
      if (best > least) corners.emplace_back(px.x, px.y);
    }
  }
  return corners;
}

struct FlowPyramid::Levels {
  std::vector<cv::Mat> pictures;
};

FlowPyramid::FlowPyramid() : levels_(std::make_shared<Levels>()) {}

FlowPyramid::FlowPyramid(const GrayImage& gray, const FlowSearch& search) {
  CV_Assert(!gray.pixels.empty());  // OpenCV would search for its border without end
  const auto levels = std::make_shared<Levels>();
  cv::buildOpticalFlowPyramid(
      ViewOf(gray), levels->pictures, {search.window_px, search.window_px}, search.num_levels);
  levels_ = levels;
}

GrayView FlowPyramid::Picture() const {
  const cv::Mat& full = levels_->pictures.at(0);
  return {full.ptr(), full.cols, full.rows, static_cast<std::ptrdiff_t>(full.step)};
}

Followed Follow(const FlowPyramid& from,
                const FlowPyramid& to,
                const std::vector<Eigen::Vector2f>& points,
                const FlowSearch& search,
                std::vector<Eigen::Vector2f> guess) {
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
      {search.window_px, search.window_px},
      search.num_levels,
      {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, search.max_steps, search.min_step_px},
      has_guess ? cv::OPTFLOW_USE_INITIAL_FLOW : 0);
  return followed;
}

}  // namespace nightmap
