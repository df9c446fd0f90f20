// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/keypoint_depth.h"

#include <algorithm>
#include <cmath>

namespace nightmap {
namespace {

constexpr int kDepthWindow_px = 2;      // half size of the window for a keypoint's depth lookup
constexpr double kMaxDepthStep = 0.05;  // relative depth difference that separates two surfaces

struct DepthSample {
  float depth_m;
  int distance2_px;  // squared distance to the keypoint
};

std::vector<DepthSample> SampleWindow(const DepthImage& depth, int x, int y, int half_size) {
  std::vector<DepthSample> samples;
  for (int dy = -half_size; dy <= half_size; ++dy) {
    for (int dx = -half_size; dx <= half_size; ++dx) {
      const int u = x + dx;
      const int v = y + dy;
      if (u < 0 || v < 0 || u >= depth.width || v >= depth.height) continue;
      const float value = depth.At(u, v);
      if (value > 0) samples.push_back({value, dx * dx + dy * dy});
    }
  }
  return samples;
}

// Mean depth of the samples on the surface of the sample nearest to the keypoint; 0 when the
// keypoint itself has no depth and the window shows more than one surface.
float SurfaceDepth_m(std::vector<DepthSample> samples, double max_step) {
  if (samples.empty()) return 0;
  const DepthSample nearest = *std::ranges::min_element(samples, {}, [](const DepthSample& sample) {
    return std::pair(sample.distance2_px, sample.depth_m);
  });
  const auto tolerance_m = static_cast<float>(max_step) * nearest.depth_m;
  double sum = 0;
  int count = 0;
  for (const DepthSample& sample : samples) {
    if (std::abs(sample.depth_m - nearest.depth_m) > tolerance_m) continue;
    sum += sample.depth_m;
    ++count;
  }
  const bool is_one_surface = count == static_cast<int>(samples.size());
  if (nearest.distance2_px > 0 && !is_one_surface) return 0;
  return static_cast<float>(sum / count);
}

}  // namespace

void LookUpDepth(const DepthImage& depth, FrameFeatures* features) {
  for (std::size_t i = 0; i < features->raw_keypoints_px.size(); ++i) {
    const Eigen::Vector2f& raw = features->raw_keypoints_px[i];
    const auto x = static_cast<int>(std::lround(raw.x()));
    const auto y = static_cast<int>(std::lround(raw.y()));
    features->depths_m[i] =
        SurfaceDepth_m(SampleWindow(depth, x, y, kDepthWindow_px), kMaxDepthStep);
  }
}

}  // namespace nightmap
