// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/synthesize_ceiling.h"

namespace nightmap {

WheelOptions SynthesizeCeilingOptions::CeilingWheels() {
  WheelOptions wheels;
  wheels.scale_bias = 0;
  wheels.heading_bias_rad_per_m = 0;
  wheels.distance_noise_m = 0.02;
  wheels.heading_noise_rad_per_root_m = 0.0175;
  return wheels;
}

std::uint64_t SynthesizeCeilingOptions::NoiseSeed() const {
  return static_cast<std::uint64_t>(noise_seed == 0 ? seed : noise_seed);
}

}  // namespace nightmap
