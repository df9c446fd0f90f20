// SPDX-License-Identifier: Apache-2.0
// The automatic exposure of the camera, and a light that changes.
#include <cmath>
#include <numbers>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "stages/ceiling/synthesize_ceiling/synthesize_ceiling.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kLightStream = 713;
constexpr double kMeteredLevel = 125;
constexpr double kExposureLag_s = 0.3;

// Slow waves between -1 and 1.
double SlowLight(double time_s, double phase_a_rad, double phase_b_rad) {
  constexpr double kPeriodA_s = 31, kPeriodB_s = 11;
  return 0.6 * std::sin(2 * std::numbers::pi * time_s / kPeriodA_s + phase_a_rad) +
         0.4 * std::sin(2 * std::numbers::pi * time_s / kPeriodB_s + phase_b_rad);
}

}  // namespace

std::vector<double> CeilingGains(const CeilingWorld& world,
                                 const std::vector<StampedPose>& building_from_camera,
                                 const SynthesizeCeilingOptions& options,
                                 int num_threads) {
  const Camera camera = options.Pinhole();
  std::vector<double> wanted(building_from_camera.size());
  ParallelFor(wanted.size(), num_threads, [&](std::size_t i) {
    wanted[i] = std::log(kMeteredLevel /
                         std::max(1.0, MeterCeiling(world, camera, building_from_camera[i].pose)));
  });
  Random random(options.NoiseSeed(), kLightStream);
  const double phase_a_rad = random.Uniform(0, 2 * std::numbers::pi);
  const double phase_b_rad = random.Uniform(0, 2 * std::numbers::pi);
  const double step_s = 1 / options.frame_rate_hz;
  const double follow = 1 - std::exp(-step_s / kExposureLag_s);
  std::vector<double> gains;
  double log_gain = wanted.empty() ? 0 : wanted.front();
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    log_gain += follow * (wanted[i] - log_gain);
    const double light = SlowLight(static_cast<double>(i) * step_s, phase_a_rad, phase_b_rad);
    gains.push_back(std::exp(log_gain) * (1 + options.light_change * light));
  }
  return gains;
}

}  // namespace nightmap
