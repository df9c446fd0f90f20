// SPDX-License-Identifier: Apache-2.0
// Light on every surface, computed once: lamps with soft shadows, and ambient light that weakens in
// corners (ambient occlusion; Zhukov et al., EGWR 1998).
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/world/ray_scene.h"
#include "pipeline/world/scene.h"

namespace nightmap {

class LightMap {
 public:
  LightMap() = default;
  // Samples every `cell_m` with `num_samples` rays for the lamps and as many for the ambient part.
  // Equal at any thread count.
  LightMap(const Scene& scene,
           const RayScene& rays,
           double cell_m,
           int num_samples,
           std::uint64_t seed,
           int num_threads);

  // Relative brightness at (a, b) in [0, 1] of a surface, bilinear between the samples.
  float At(int surface_idx, double a, double b) const;

 private:
  struct Grid {
    int num_u = 0;  // samples along edge_u, at least 2
    int num_v = 0;
    std::size_t first = 0;
  };
  std::vector<Grid> grids_;
  std::vector<float> samples_;
};

}  // namespace nightmap
