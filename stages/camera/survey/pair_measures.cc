// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/survey/pair_measures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "pipeline/base/median.h"
#include "pipeline/camera/follow_corners.h"

namespace nightmap {
namespace {

constexpr int kCornerCell_px = 20;
constexpr FlowSearch kSearch{.window_px = 15};
constexpr int kNumGainCells = 8;  // along each side
constexpr std::size_t kMinGainCells = 8;
// Bounds of a cell: pixels of darker and brighter ones are black or white, and tell no gain.
constexpr int kLeastLevel = 8;
constexpr int kMostLevel = 220;
constexpr float kMaxWayBack_px = 1;

cv::Mat PixelsOf(const GrayImage& gray) {
  // OpenCV takes no const pixels; nothing here writes them.
  return {gray.height, gray.width, CV_8UC1, const_cast<std::uint8_t*>(gray.pixels.data())};
}

// Exposure must not keep corners from being followed: the flow compares gray levels.
GrayImage Equalized(const GrayImage& gray) {
  GrayImage result{gray.width, gray.height, 1, gray.pixels};
  cv::Mat pixels = PixelsOf(result);
  cv::equalizeHist(PixelsOf(gray), pixels);
  return result;
}

void FollowCorners(const GrayImage& previous, const GrayImage& current, PairMeasures* measures) {
  const auto corners = Corners(previous, kCornerCell_px);
  if (corners.empty()) return;
  const FlowPyramid from(previous, kSearch), to(current, kSearch);
  const Followed there = Follow(from, to, corners, kSearch);
  const Followed back = Follow(to, from, there.points, kSearch);
  std::vector<double> flow_px;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (there.is_found[i] == 0 || back.is_found[i] == 0) continue;
    if (Distance_px(back.points[i], corners[i]) > kMaxWayBack_px) continue;
    flow_px.push_back(Distance_px(there.points[i], corners[i]));
  }
  measures->tracked_share =
      static_cast<double>(flow_px.size()) / static_cast<double>(corners.size());
  measures->flow_px = Median(std::move(flow_px));
}

}  // namespace

Gain GainBetween(const GrayImage& previous, const GrayImage& current) {
  cv::Mat before, after;
  cv::resize(PixelsOf(previous), before, {kNumGainCells, kNumGainCells}, 0, 0, cv::INTER_AREA);
  cv::resize(PixelsOf(current), after, {kNumGainCells, kNumGainCells}, 0, 0, cv::INTER_AREA);
  std::vector<double> logs;
  for (int i = 0; i < kNumGainCells * kNumGainCells; ++i) {
    const int levels[] = {before.data[i], after.data[i]};
    const bool is_clipped = std::ranges::any_of(
        levels, [](int level) { return level < kLeastLevel || level > kMostLevel; });
    if (!is_clipped) logs.push_back(std::log(static_cast<double>(levels[1]) / levels[0]));
  }
  if (logs.size() < kMinGainCells) return {};
  const double middle = Median(logs);
  for (double& value : logs) value = std::abs(value - middle);
  return {std::exp(middle), Median(std::move(logs))};
}

PairMeasures MeasurePair(const GrayImage& previous, const GrayImage& current) {
  PairMeasures measures;
  measures.has_previous = true;
  measures.same_color = previous.pixels == current.pixels;
  FollowCorners(Equalized(previous), Equalized(current), &measures);
  const Gain gain = GainBetween(previous, current);
  if (std::abs(std::log(gain.ratio)) > 2 * gain.spread) measures.gain = gain.ratio;
  return measures;
}

}  // namespace nightmap
