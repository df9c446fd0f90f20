// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_tracks/corner_flow.h"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace nightmap {
namespace {

const FlowSearch kSearch{15, 3, 20, 0.02};
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

// Written so that a coordinate that is no number lies outside.
bool IsInside(const Eigen::Vector2f& pixel, const GrayView& image, int border_px) {
  const auto border = static_cast<float>(border_px);
  return pixel.x() >= border && pixel.y() >= border &&
         pixel.x() <= static_cast<float>(image.width - 1) - border &&
         pixel.y() <= static_cast<float>(image.height - 1) - border;
}

}  // namespace

FlowPyramid PrepareForFlow(const GrayImage& gray) {
  GrayImage even = gray;
  cv::Mat image(even.height, even.width, CV_8UC1, even.pixels.data());
  CV_Assert(!image.empty());
  cv::Scalar mean, deviation;
  cv::meanStdDev(image, mean, deviation);
  const double gain = std::min(kMaxGain, kContrast / std::max(1.0, deviation[0]));
  image.convertTo(image, CV_8U, gain, kMean - gain * mean[0]);
  cv::GaussianBlur(image, image, {5, 5}, kBlur_px);
  return {even, kSearch};
}

std::vector<FollowedCorner> FollowCorners(const FlowPyramid& from,
                                          const FlowPyramid& to,
                                          const std::vector<Eigen::Vector2f>& pixels,
                                          const std::vector<Eigen::Vector2f>& steps_px,
                                          const FlowOptions& options) {
  std::vector<FollowedCorner> followed(pixels.size());
  if (pixels.empty()) return followed;
  std::vector<Eigen::Vector2f> predicted, found, start_back;
  for (std::size_t i = 0; i < pixels.size(); ++i) predicted.push_back(pixels[i] + steps_px[i]);
  const GrayView image = to.Picture();
  const Followed forward = Follow(from, to, pixels, kSearch, predicted);
  std::vector<std::size_t> of_found;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const Eigen::Vector2f& pixel = forward.points[i];
    if (!IsInside(pixel, image, options.border_px)) {
      followed[i].end = TrackEnd::kBorder;
    } else if (!forward.is_found[i]) {
      followed[i].end = TrackEnd::kLost;
    } else {
      of_found.push_back(i);
      found.push_back(pixel);
      start_back.push_back(pixel - (predicted[i] - pixels[i]));
    }
  }
  if (found.empty()) return followed;
  const Followed back = Follow(to, from, found, kSearch, start_back);
  for (std::size_t k = 0; k < found.size(); ++k) {
    FollowedCorner& corner = followed[of_found[k]];
    const double error_px = Distance_px(back.points[k], pixels[of_found[k]]);
    if (!back.is_found[k] || !(error_px <= kMaxBackwardError_px)) {
      corner.end = TrackEnd::kBackward;
      continue;
    }
    const auto refined = RefineCorner(image, found[k], kRefineRadius_px, kMaxRefinement_px);
    if (!refined) {
      corner.end = TrackEnd::kOffCorner;
    } else if (!IsInside(*refined, image, options.border_px)) {
      corner.end = TrackEnd::kBorder;
    } else {
      corner.pixel = *refined;
    }
  }
  return followed;
}

}  // namespace nightmap
