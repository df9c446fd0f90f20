// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/epipolar_check.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "pipeline/base/random.h"
#include "pipeline/camera/follow_corners.h"

namespace nightmap {
namespace {

// A corner in both frames.
struct SeenTwice {
  cv::Point2f before, now;  // without distortion
  Eigen::Vector2f seen;     // now, in the picture
};

bool IsInside(const EpipolarOptions& options,
              const SmallCamera& camera,
              const Eigen::Vector2f& px) {
  const auto border = static_cast<float>(options.border_px);
  return px.x() >= border && px.x() <= static_cast<float>(camera.gray.width - 1) - border &&
         px.y() >= border && px.y() <= static_cast<float>(camera.gray.height - 1) - border &&
         camera.gray.Sees(px.cast<double>());
}

cv::Mat ViewOf(const GrayImage& gray) {
  // OpenCV takes no const pixels; nothing here writes them.
  return {gray.height, gray.width, CV_8UC1, const_cast<std::uint8_t*>(gray.pixels.data())};
}

// Mean absolute difference of 3 x 3 pixels, gray levels.
double SmallPatchDifference(const GrayImage& a,
                            const Eigen::Vector2f& at_a,
                            const GrayImage& b,
                            const Eigen::Vector2f& at_b) {
  cv::Mat patch_a, patch_b;
  cv::getRectSubPix(ViewOf(a), {3, 3}, {at_a.x(), at_a.y()}, patch_a, CV_32F);
  cv::getRectSubPix(ViewOf(b), {3, 3}, {at_b.x(), at_b.y()}, patch_b, CV_32F);
  return cv::norm(patch_a, patch_b, cv::NORM_L1) / 9;
}

cv::Point2f Undistorted(const SmallCamera& camera, const Eigen::Vector2f& px) {
  const Eigen::Vector2d at = camera.gray.Undistort(px.cast<double>());
  return {static_cast<float>(at.x()), static_cast<float>(at.y())};
}

std::vector<SeenTwice> Pairs(const EpipolarOptions& options,
                             int window_px,
                             const SmallCamera& camera,
                             const SmallFrame& previous,
                             const SmallFrame& frame) {
  std::vector<Eigen::Vector2f> corners;
  std::ranges::copy_if(previous.corners, std::back_inserter(corners), [&](const auto& corner) {
    return IsInside(options, camera, corner);
  });
  if (corners.empty()) return {};
  const Followed followed = Follow(previous.pyramid, frame.pyramid, corners, {window_px});
  std::vector<SeenTwice> pairs;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2f& seen = followed.points[i];
    if (!followed.is_found[i] || !IsInside(options, camera, seen)) continue;
    if (SmallPatchDifference(previous.gray, corners[i], frame.gray, seen) >
        options.max_patch_difference) {
      continue;
    }
    pairs.push_back({Undistorted(camera, corners[i]), Undistorted(camera, seen), seen});
  }
  return pairs;
}

}  // namespace

std::optional<std::vector<Eigen::Vector2f>> MovingPoints(const EpipolarOptions& options,
                                                         int window_px,
                                                         const SmallCamera& camera,
                                                         const SmallFrame& previous,
                                                         const SmallFrame& frame,
                                                         std::uint64_t seed) {
  std::vector<SeenTwice> pairs = Pairs(options, window_px, camera, previous, frame);
  if (std::ssize(pairs) < options.min_points) return std::nullopt;
  // OpenCV's RANSAC has a generator of its own, which draws the same indices in each call: the seed
  // gives the order of the pairs. With fewer than 15 pairs it would fall back to another method.
  Random random(seed);
  for (std::size_t i = pairs.size() - 1; i > 0; --i)
    std::swap(pairs[i], pairs[random.Index(i + 1)]);
  std::vector<cv::Point2f> before, now;
  for (const SeenTwice& pair : pairs) {
    before.push_back(pair.before);
    now.push_back(pair.now);
  }
  const cv::Mat fundamental = cv::findFundamentalMat(
      before, now, cv::FM_RANSAC, options.ransac_px, options.ransac_confidence);
  if (fundamental.empty()) return std::nullopt;
  std::vector<cv::Vec3f> lines;
  cv::computeCorrespondEpilines(before, 1, fundamental, lines);
  std::vector<Eigen::Vector2f> moving;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const double distance_px = std::abs(lines[i].dot({now[i].x, now[i].y, 1}));
    if (distance_px > options.max_epipolar_px) moving.push_back(pairs[i].seen);
  }
  return moving;
}

std::vector<bool> RegionsThatMove(const EpipolarOptions& options,
                                  const Image<std::int32_t>& regions,
                                  int num_regions,
                                  const std::vector<Eigen::Vector2f>& points) {
  std::vector<int> counts(static_cast<std::size_t>(num_regions) + 1);
  for (const Eigen::Vector2f& point : points) {
    const int x = std::clamp(static_cast<int>(point.x() / 2), 0, regions.width - 1);
    const int y = std::clamp(static_cast<int>(point.y() / 2), 0, regions.height - 1);
    ++counts[static_cast<std::size_t>(regions.At(x, y))];
  }
  std::vector<bool> moves;
  for (std::size_t i = 1; i < counts.size(); ++i) {
    moves.push_back(counts[i] >= options.min_moving_points);
  }
  return moves;
}

Image<float> PublishedDecision(const EpipolarOptions& options,
                               int window_px,
                               const SmallCamera& camera,
                               const SmallFrame* previous,
                               const SmallFrame& frame,
                               const LabelledRegions& regions,
                               std::uint64_t seed) {
  Image<float> decided = ZerosLike(frame.depth);
  std::vector<bool> moves(static_cast<std::size_t>(regions.num), true);
  std::optional<std::vector<Eigen::Vector2f>> points;
  if (previous != nullptr) {
    points = MovingPoints(options, window_px, camera, *previous, frame, seed);
    if (points && regions.num > 0) {
      moves = RegionsThatMove(options, regions.of_pixel, regions.num, *points);
    }
  }
  const auto region_at = [&](std::size_t pixel) {
    return regions.num > 0 ? regions.of_pixel.pixels[pixel] : 0;
  };
  for (std::size_t i = 0; i < decided.pixels.size(); ++i) {
    const int region = region_at(i);
    decided.pixels[i] = region > 0 && moves[static_cast<std::size_t>(region - 1)] ? 1 : -1;
  }
  for (const Eigen::Vector2f& point : points.value_or(std::vector<Eigen::Vector2f>())) {
    const int x = std::clamp(static_cast<int>(point.x() / 2), 0, decided.width - 1);
    const int y = std::clamp(static_cast<int>(point.y() / 2), 0, decided.height - 1);
    if (region_at(static_cast<std::size_t>(y * decided.width + x)) == 0) decided.At(x, y) = 1;
  }
  return decided;
}

}  // namespace nightmap
