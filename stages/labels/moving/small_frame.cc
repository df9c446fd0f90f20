// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/small_frame.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"

namespace nightmap {
namespace {

constexpr double kGrayWidth_px = 320;

// The camera of every `step`-th pixel, each the mean of a block.
Camera Reduced(const Camera& camera, int step) {
  Camera reduced = camera;
  reduced.width = camera.width / step;
  reduced.height = camera.height / step;
  reduced.fx /= step;
  reduced.fy /= step;
  reduced.cx = (camera.cx + 0.5) / step - 0.5;
  reduced.cy = (camera.cy + 0.5) / step - 0.5;
  return reduced;
}

// 0 where nothing in the block was measured.
float MedianOfBlock(const DepthImage& depth, int left, int top, int step) {
  std::vector<float> measured;
  for (int y = top; y < top + step; ++y) {
    for (int x = left; x < left + step; ++x) {
      if (depth.At(x, y) > 0) measured.push_back(depth.At(x, y));
    }
  }
  return Median(std::move(measured));
}

GrayImage ReduceGray(const ColorImage& color, const Camera& reduced, int step) {
  GrayImage gray = ToGray(color);
  const cv::Mat whole(gray.height, gray.width, CV_8UC1, gray.pixels.data());
  GrayImage small{reduced.width, reduced.height, 1, {}};
  small.pixels.resize(static_cast<std::size_t>(small.width) *
                      static_cast<std::size_t>(small.height));
  cv::Mat view(small.height, small.width, CV_8UC1, small.pixels.data());
  cv::resize(whole({0, 0, small.width * step, small.height * step}),
             view,
             view.size(),
             0,
             0,
             cv::INTER_AREA);
  return small;
}

DepthImage ReduceDepth(const DepthImage& depth, const Camera& reduced, int step) {
  DepthImage small{reduced.width, reduced.height, 1, {}};
  small.pixels.resize(static_cast<std::size_t>(small.width) *
                      static_cast<std::size_t>(small.height));
  if (depth.pixels.empty()) return small;
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      small.At(x, y) = MedianOfBlock(depth, x * step, y * step, step);
    }
  }
  return small;
}

GrayImage ReduceMask(const GrayImage& mask, const Camera& reduced, int step) {
  if (mask.pixels.empty()) return {};
  if (mask.width / step != reduced.width || mask.height / step != reduced.height) {
    throw DataError("a mask of {} x {} pixels does not fit the pictures of its camera",
                    mask.width,
                    mask.height);
  }
  GrayImage small{reduced.width, reduced.height, 1, {}};
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      small.pixels.push_back(mask.At(x * step + step / 2, y * step + step / 2));
    }
  }
  return small;
}

}  // namespace

SmallCamera Shrink(const RgbdCamera& camera) {
  SmallCamera small;
  small.gray_step = std::max(1, static_cast<int>(std::lround(camera.color.width / kGrayWidth_px)));
  small.depth_step = 2 * small.gray_step;
  small.gray = Reduced(camera.color, small.gray_step);
  small.depth = Reduced(camera.color, small.depth_step);
  small.noise = camera.noise;
  for (int y = 0; y < small.depth.height; ++y) {
    for (int x = 0; x < small.depth.width; ++x) {
      small.depth_rays.push_back(small.depth.BackProject({x, y}, 1));
    }
  }
  return small;
}

Image<float> ZerosLike(const DepthImage& depth) {
  Image<float> image{depth.width, depth.height, 1, {}};
  image.pixels.resize(depth.pixels.size());
  return image;
}

SmallFrame Shrink(const RgbdImages& images, const SmallCamera& camera) {
  return {ReduceGray(images.color, camera.gray, camera.gray_step),
          ReduceDepth(images.depth, camera.depth, camera.depth_step),
          ReduceMask(images.moving, camera.depth, camera.depth_step),
          {},
          {}};
}

GrayImage EnlargeDepthMask(const GrayImage& mask, const SmallCamera& small, const Camera& whole) {
  GrayImage enlarged{whole.width, whole.height, 1, {}};
  for (int y = 0; y < whole.height; ++y) {
    for (int x = 0; x < whole.width; ++x) {
      enlarged.pixels.push_back(mask.At(std::min(x / small.depth_step, mask.width - 1),
                                        std::min(y / small.depth_step, mask.height - 1)));
    }
  }
  return enlarged;
}

float DepthAt(const SmallFrame& frame, const Eigen::Vector2f& gray_px) {
  const int x = std::clamp(static_cast<int>(gray_px.x() / 2), 0, frame.depth.width - 1);
  const int y = std::clamp(static_cast<int>(gray_px.y() / 2), 0, frame.depth.height - 1);
  return frame.depth.At(x, y);
}

bool MayMove(const SmallFrame& frame, const Eigen::Vector2f& gray_px) {
  if (frame.may_move.pixels.empty()) return false;
  const int x = std::clamp(static_cast<int>(gray_px.x() / 2), 0, frame.may_move.width - 1);
  const int y = std::clamp(static_cast<int>(gray_px.y() / 2), 0, frame.may_move.height - 1);
  return frame.may_move.At(x, y) > 0;
}

}  // namespace nightmap
