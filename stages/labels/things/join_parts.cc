// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/join_parts.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <tuple>

namespace nightmap {
namespace {

bool IsPartOf(const VoxelLabels& voxels, const Cluster& part, const UprightBox& box) {
  Eigen::AlignedBox3d around = box.extent;
  around.min().array() -= voxels.resolution_m;
  around.max().array() += voxels.resolution_m;
  const Rigid2 box_from_map = box.map_from_box.Inverse();
  const auto is_inside = [&](std::size_t i) {
    Eigen::Vector3d point = VoxelCentre(voxels.keys[i], voxels.resolution_m);
    point.head<2>() = box_from_map * Eigen::Vector2d(point.head<2>());
    return around.contains(point);
  };
  return 2 * std::ranges::count_if(part.voxels, is_inside) >
         static_cast<std::ptrdiff_t>(part.voxels.size());
}

}  // namespace

std::vector<Cluster> JoinParts(const VoxelLabels& voxels,
                               const std::vector<Cluster>& clusters,
                               const std::vector<UprightBox>& boxes) {
  std::vector<std::size_t> order(clusters.size());  // the largest first
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(
      order, std::ranges::greater(), [&](std::size_t i) { return clusters[i].voxels.size(); });
  std::vector<std::size_t> wholes;  // which clusters they are
  std::vector<Cluster> joined;
  for (const std::size_t i : order) {
    const auto whole = std::ranges::find_if(wholes, [&](std::size_t other) {
      return clusters[other].label == clusters[i].label &&
             IsPartOf(voxels, clusters[i], boxes[other]);
    });
    if (whole == wholes.end()) {
      wholes.push_back(i);
      joined.push_back(clusters[i]);
    } else {
      AddPart(clusters[i], &joined[static_cast<std::size_t>(whole - wholes.begin())]);
    }
  }
  std::ranges::sort(joined, {}, [](const Cluster& cluster) {
    return std::tuple(cluster.label, cluster.voxels.front());
  });
  return joined;
}

}  // namespace nightmap
