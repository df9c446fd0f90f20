// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nightmap {

// Log-odds of the inverse sensor model (Moravec and Elfes, High resolution maps from wide angle
// sonar, 1985) with clamping, so that a map can follow change and its octree can be pruned.
struct SensorModel {
  float hit = 0.85F;
  float miss = -0.4F;
  float min = -2.0F;
  float max = 3.5F;
};

}  // namespace nightmap
