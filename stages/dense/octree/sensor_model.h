// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nightmap {

// Log-odds of the inverse sensor model (Moravec and Elfes, High resolution maps from wide angle
// sonar, 1985) with clamping, so that a map can follow change and its octree can be pruned.
// A voxel is occupied when its log-odds reach the threshold and enough keyframes hit it. A voxel
// that reaches it by fewer is neither occupied nor free.
struct SensorModel {
  float hit = 0.85F;
  float miss = -0.4F;
  float min = -2.0F;
  float max = 3.5F;
  float threshold = 0;    // leaves hold log-odds less this
  int min_keyframes = 1;  // that hit an occupied voxel, up to BlockColors::kMaxKeyframes
};

}  // namespace nightmap
