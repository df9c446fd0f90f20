// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "pipeline/base/random.h"
#include "pipeline/world/render.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kDepthNoiseStream = 402;
constexpr float kMinJump = 0.03F;  // relative depth difference between neighbouring surfaces

// Whether a neighbour lies on another surface at a clearly different depth, where a
// structured-light sensor loses its pattern.
bool IsDepthEdge(const DepthImage& depth, const Image<std::int32_t>& surface_idx, int x, int y) {
  const float center = depth.At(x, y);
  for (int ny = std::max(0, y - 1); ny <= std::min(depth.height - 1, y + 1); ++ny) {
    for (int nx = std::max(0, x - 1); nx <= std::min(depth.width - 1, x + 1); ++nx) {
      const bool is_other = surface_idx.At(nx, ny) != surface_idx.At(x, y);
      if (is_other && std::abs(depth.At(nx, ny) - center) > kMinJump * center) return true;
    }
  }
  return false;
}

// Depth of the nearest disparity that the sensor can resolve.
double Quantize(double depth_m, const Camera& camera, const DepthSensorOptions& sensor) {
  if (sensor.disparity_step_px <= 0) return depth_m;
  const double focal_baseline = camera.fx * sensor.baseline_m;
  // (std::round is a call, and floor an instruction.)
  const double num_steps = std::floor(focal_baseline / depth_m / sensor.disparity_step_px + 0.5);
  return focal_baseline / (std::max(1.0, num_steps) * sensor.disparity_step_px);
}

}  // namespace

DepthImage MeasureDepth(const DepthImage& exact_depth,
                        const Image<std::int32_t>& surface_idx,
                        const Image<float>& incidence_cosine,
                        const Camera& camera,
                        const DepthSensorOptions& sensor,
                        std::uint64_t noise_seed) {
  DepthImage measured = exact_depth;
  Random random(noise_seed, kDepthNoiseStream);
  const float min_cosine = static_cast<float>(std::cos(sensor.max_incidence_rad));
  for (int y = 0; y < exact_depth.height; ++y) {
    for (int x = 0; x < exact_depth.width; ++x) {
      // Drawn for every pixel, so that one hole does not shift the noise of all later pixels.
      const double gaussian = random.Gaussian();
      const double uniform = random.Uniform();
      const double exact_m = exact_depth.At(x, y);
      float& depth_m = measured.At(x, y);
      depth_m = 0;
      if (exact_m <= 0 || incidence_cosine.At(x, y) < min_cosine) continue;
      if (uniform < sensor.dropout_ratio) continue;
      if (uniform < sensor.edge_hole_ratio && IsDepthEdge(exact_depth, surface_idx, x, y)) continue;
      const double beyond_m = exact_m - 0.4;
      const double sigma_m =
          sensor.noise_constant_m + sensor.noise_quadratic_per_m * beyond_m * beyond_m;
      const double noisy_m = Quantize(std::max(0.05, exact_m + sigma_m * gaussian), camera, sensor);
      if (noisy_m < sensor.min_depth_m || noisy_m > sensor.max_depth_m) continue;
      depth_m = static_cast<float>(noisy_m);
    }
  }
  return measured;
}

}  // namespace nightmap
