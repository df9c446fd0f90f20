// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_clouds/join_clouds.h"

#include <algorithm>

namespace nightmap {

void RunJoinClouds(const std::vector<PointSource>& clouds,
                   double voxel_size_m,
                   const std::function<void(const CloudPoint&)>& add) {
  struct Head {
    CloudPoint point;
    std::size_t cloud;
  };
  const auto later = [voxel_size_m](const Head& a, const Head& b) {
    return ByVoxel(b.point, a.point, voxel_size_m);
  };
  std::vector<Head> heads;  // a heap with the first point at the front
  const auto advance = [&](std::size_t cloud) {
    const auto point = clouds[cloud]();
    if (!point) return;
    heads.push_back({*point, cloud});
    std::ranges::push_heap(heads, later);
  };
  for (std::size_t cloud = 0; cloud < clouds.size(); ++cloud) advance(cloud);
  while (!heads.empty()) {
    std::ranges::pop_heap(heads, later);
    const Head head = heads.back();
    heads.pop_back();
    add(head.point);
    advance(head.cloud);
  }
}

}  // namespace nightmap
