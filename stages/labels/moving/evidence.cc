// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/evidence.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <numbers>

namespace nightmap {
namespace {

int GrayAt(const SmallFrame& frame, int depth_x, int depth_y) {
  return frame.gray.At(std::min(2 * depth_x, frame.gray.width - 1),
                       std::min(2 * depth_y, frame.gray.height - 1));
}

// Values that a frame shows at a pixel and its neighbours, beside a surface of this depth and gray.
struct Around {
  double nearest_m = 0;  // 0: something there is not measured
  double least_step_m = std::numeric_limits<double>::max();
  int least_gray_difference = 255;
};

Around Look(const SmallFrame& frame, int at_x, int at_y, double depth_m, int gray) {
  Around around;
  around.nearest_m = std::numeric_limits<double>::max();
  for (int y = std::max(at_y - 1, 0); y <= std::min(at_y + 1, frame.depth.height - 1); ++y) {
    for (int x = std::max(at_x - 1, 0); x <= std::min(at_x + 1, frame.depth.width - 1); ++x) {
      const double there_m = frame.depth.At(x, y);
      around.nearest_m = std::min(around.nearest_m, there_m);
      if (there_m <= 0) continue;
      around.least_step_m = std::min(around.least_step_m, std::abs(there_m - depth_m));
      around.least_gray_difference =
          std::min(around.least_gray_difference, std::abs(gray - GrayAt(frame, x, y)));
    }
  }
  return around;
}

// 0.1 .. 0.3: how surely the gray of a pixel would differ if the surface had moved by a few pixels.
// Against a corner that is followed, whose weight is 1, a gray that agrees says little.
float Texture(const SmallFrame& frame, int x, int y) {
  constexpr float kSure = 30;  // gray levels over 4 pixels of depth
  const int left = GrayAt(frame, std::max(x - 2, 0), y);
  const int right = GrayAt(frame, std::min(x + 2, frame.depth.width - 1), y);
  const int above = GrayAt(frame, x, std::max(y - 2, 0));
  const int below = GrayAt(frame, x, std::min(y + 2, frame.depth.height - 1));
  const auto contrast = static_cast<float>(std::hypot(right - left, below - above));
  return std::min(0.3F, 0.1F + contrast / kSure);
}

}  // namespace

Evidence& Evidence::operator+=(const Evidence& more) {
  std::ranges::transform(gone.pixels, more.gone.pixels, gone.pixels.begin(), std::plus<>());
  std::ranges::transform(stays.pixels, more.stays.pixels, stays.pixels.begin(), std::plus<>());
  return *this;
}

double Margin_m(const EvidenceOptions& options, const SmallCamera& camera, double depth_m) {
  return options.min_difference_m +
         options.num_sigmas * std::numbers::sqrt2 * camera.noise.Sigma_m(depth_m);
}

void AddDepthEvidence(const EvidenceOptions& options,
                      const SmallCamera& camera,
                      const SmallFrame& frame,
                      const SmallFrame& other,
                      const Rigid3& other_from_frame,
                      Evidence* evidence) {
  const Eigen::Matrix3d rotation = other_from_frame.rotation.toRotationMatrix();
  for (int y = 0; y < frame.depth.height; ++y) {
    for (int x = 0; x < frame.depth.width; ++x) {
      const double depth_m = frame.depth.At(x, y);
      if (depth_m <= 0) continue;
      const auto i = static_cast<std::size_t>(y * frame.depth.width + x);
      const Eigen::Vector3d point =
          rotation * (camera.depth_rays[i] * depth_m) + other_from_frame.translation;
      const auto seen = camera.depth.Project(point);
      if (!seen || !camera.depth.Contains(*seen)) continue;
      const int at_x = static_cast<int>(std::lround(seen->x()));
      const int at_y = static_cast<int>(std::lround(seen->y()));
      const double margin_m = Margin_m(options, camera, point.z());
      const Around around = Look(other, at_x, at_y, point.z(), GrayAt(frame, x, y));
      if (around.nearest_m <= 0) continue;
      if (around.nearest_m > point.z() + margin_m) {
        evidence->gone.At(x, y) += 1;
      } else if (around.least_step_m < margin_m &&
                 around.least_gray_difference <= options.max_gray_difference) {
        evidence->stays.At(x, y) += Texture(frame, x, y);
      }
    }
  }
}

}  // namespace nightmap
