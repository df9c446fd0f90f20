// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_tracks/corner_flow.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "pipeline/camera/refine_corner.h"

namespace nightmap {

struct FlowPicture {
  std::vector<cv::Mat> pyramid;  // of each level the pixels, then the gradients
};

namespace {

constexpr int kWindow_px = 15;  // size of the patch that flow compares
// Pictures of half the size each above the full one, from which flow starts.
constexpr int kNumPyramidLevels = 3;
// A track ends when the flow back misses its corner by more.
constexpr double kMaxBackwardError_px = 0.5;
// Half size of the window whose gradients put a track back onto its corner.
constexpr int kRefineRadius_px = 4;
// A track ends when its corner is farther from where flow leads.
constexpr double kMaxRefinement_px = 1;
constexpr double kMean = 128;
constexpr double kContrast = 50;  // standard deviation, in gray levels
constexpr double kMaxGain = 4;    // the noise of a blank picture is not made to look like corners
constexpr double kBlur_px = 0.8;  // as the corners were found with (harris_corners.cc)

using Pixels = std::vector<cv::Point2f>;

// The picture at the mean and contrast of all pictures.
cv::Mat EvenLight(const cv::Mat& image) {
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  const double gain = std::min(kMaxGain, kContrast / std::max(1.0, deviation[0]));
  cv::Mat even;
  image.convertTo(even, CV_8U, gain, kMean - gain * mean[0]);
  return even;
}

struct Flow {
  Pixels pixels;
  std::vector<unsigned char> is_found;
};

Flow FlowFrom(const FlowPicture& from,
              const FlowPicture& to,
              const Pixels& pixels,
              const Pixels& predicted) {
  Flow flow{predicted, {}};
  cv::calcOpticalFlowPyrLK(from.pyramid,
                           to.pyramid,
                           pixels,
                           flow.pixels,
                           flow.is_found,
                           cv::noArray(),
                           {kWindow_px, kWindow_px},
                           kNumPyramidLevels,
                           {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.02},
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  return flow;
}

// Written so that a coordinate that is no number lies outside.
bool IsInside(const cv::Point2f& pixel, const cv::Mat& image, int border_px) {
  const auto border = static_cast<float>(border_px);
  return pixel.x >= border && pixel.y >= border &&
         pixel.x <= static_cast<float>(image.cols - 1) - border &&
         pixel.y <= static_cast<float>(image.rows - 1) - border;
}

float Distance_px(const cv::Point2f& a, const cv::Point2f& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

}  // namespace

std::shared_ptr<const FlowPicture> PrepareForFlow(const GrayImage& gray) {
  const cv::Mat image(
      gray.height, gray.width, CV_8UC1, const_cast<std::uint8_t*>(gray.pixels.data()));
  CV_Assert(!image.empty());  // OpenCV would search for its border without end
  cv::Mat even = EvenLight(image);
  cv::GaussianBlur(even, even, {5, 5}, kBlur_px);
  auto picture = std::make_shared<FlowPicture>();
  cv::buildOpticalFlowPyramid(even, picture->pyramid, {kWindow_px, kWindow_px}, kNumPyramidLevels);
  return picture;
}

std::vector<FollowedCorner> FollowCorners(const FlowPicture& from,
                                          const FlowPicture& to,
                                          const std::vector<Eigen::Vector2f>& pixels,
                                          const std::vector<Eigen::Vector2f>& steps_px,
                                          const FlowOptions& options) {
  std::vector<FollowedCorner> followed(pixels.size());
  Pixels origins, predicted;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Vector2f there = pixels[i] + steps_px[i];
    origins.emplace_back(pixels[i].x(), pixels[i].y());
    predicted.emplace_back(there.x(), there.y());
  }
  if (origins.empty()) return followed;
  const cv::Mat& image = to.pyramid.front();
  const Flow forward = FlowFrom(from, to, origins, predicted);
  Pixels found, start_back;
  std::vector<std::size_t> of_found;
  for (std::size_t i = 0; i < origins.size(); ++i) {
    const cv::Point2f& pixel = forward.pixels[i];
    if (!IsInside(pixel, image, options.border_px)) {
      followed[i].end = TrackEnd::kBorder;
    } else if (!forward.is_found[i]) {
      followed[i].end = TrackEnd::kLost;
    } else {
      of_found.push_back(i);
      found.push_back(pixel);
      start_back.push_back(pixel - (predicted[i] - origins[i]));
    }
  }
  if (found.empty()) return followed;
  const Flow back = FlowFrom(to, from, found, start_back);
  const GrayView view{image.ptr(), image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step)};
  for (std::size_t k = 0; k < found.size(); ++k) {
    FollowedCorner& corner = followed[of_found[k]];
    const float error_px = Distance_px(back.pixels[k], origins[of_found[k]]);
    if (!back.is_found[k] || !(error_px <= kMaxBackwardError_px)) {
      corner.end = TrackEnd::kBackward;
      continue;
    }
    const auto refined =
        RefineCorner(view, {found[k].x, found[k].y}, kRefineRadius_px, kMaxRefinement_px);
    if (!refined) {
      corner.end = TrackEnd::kOffCorner;
    } else if (!IsInside({refined->x(), refined->y()}, image, options.border_px)) {
      corner.end = TrackEnd::kBorder;
    } else {
      corner.pixel = *refined;
    }
  }
  return followed;
}

}  // namespace nightmap
