// SPDX-License-Identifier: Apache-2.0
#include "stages/things/tops.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <tuple>

#include "stages/things/upright_box.h"

namespace nightmap {
namespace {

constexpr double kMaxAboveShare = 0.05;  // of a thing's voxels that may be above its top
constexpr double kMaxFreeShare = 0.1;    // of the rectangle around two parts of a top

using Points = std::vector<Eigen::Vector3d>;

struct Top {
  int layer = 0;
  Points points;  // centres of the voxels of this layer and those beside it
};

Top TopOf(const VoxelLabels& voxels, const Cluster& cluster, int layer) {
  Top top{layer, {}};
  for (const std::size_t i : cluster.voxels) {
    if (std::abs(voxels.keys[i].z() - layer) > 1) continue;
    top.points.push_back(VoxelCentre(voxels.keys[i], voxels.resolution_m));
  }
  return top;
}

bool AreNear(const Points& points, const Points& others, double distance_m) {
  return std::ranges::any_of(points, [&](const Eigen::Vector3d& point) {
    return std::ranges::any_of(others, [&](const Eigen::Vector3d& other) {
      return (point - other).head<2>().squaredNorm() <= distance_m * distance_m;
    });
  });
}

// Share of the rectangle around the points that was seen free at a layer.
double FreeShare(const LabelledSpace& space, const Points& points, int layer) {
  const double resolution_m = space.Resolution_m();
  const UprightBox box = FitBox(points, resolution_m);
  int num_free = 0, num_all = 0;
  const Eigen::Vector3d min = box.extent.min();
  const Eigen::Vector3d max = box.extent.max();
  for (double x = min.x() + resolution_m / 2; x < max.x(); x += resolution_m) {
    for (double y = min.y() + resolution_m / 2; y < max.y(); y += resolution_m) {
      const Eigen::Vector3d place = box.ToMap({x, y, (layer + 0.5) * resolution_m});
      num_free += space.At(VoxelOf(place, resolution_m)) == VoxelState::kFree;
      ++num_all;
    }
  }
  return num_all > 0 ? static_cast<double>(num_free) / num_all : 0;
}

bool AreOne(const LabelledSpace& space, double max_hidden_m, const Top& a, const Top& b) {
  if (std::abs(a.layer - b.layer) > 1 || !AreNear(a.points, b.points, max_hidden_m)) return false;
  Points both = a.points;
  both.insert(both.end(), b.points.begin(), b.points.end());
  const int layer = a.points.size() >= b.points.size() ? a.layer : b.layer;
  return FreeShare(space, both, layer) <= kMaxFreeShare;
}

}  // namespace

std::optional<int> TopLayer(const VoxelLabels& voxels, const Cluster& cluster, double min_share) {
  std::map<int, std::size_t> counts;
  for (const std::size_t i : cluster.voxels) ++counts[voxels.keys[i].z()];
  const auto most = std::ranges::max_element(
      counts, {}, [](const auto& layer_and_count) { return layer_and_count.second; });
  double num_near = 0, num_above = 0;
  for (const auto& [layer, count] : counts) {
    if (std::abs(layer - most->first) <= 1) num_near += static_cast<double>(count);
    if (layer > most->first + 1) num_above += static_cast<double>(count);
  }
  const auto num = static_cast<double>(cluster.voxels.size());
  if (num_near < min_share * num || num_above > kMaxAboveShare * num) return std::nullopt;
  return most->first;
}

std::vector<Cluster> JoinTops(const VoxelLabels& voxels,
                              const LabelledSpace& space,
                              double max_hidden_m,
                              std::vector<Cluster> clusters) {
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    for (std::size_t j = i + 1; j < clusters.size(); ++j) {
      if (clusters[j].label != clusters[i].label) break;
      const auto layer = TopLayer(voxels, clusters[i], kTopPartShare);
      const auto other_layer = TopLayer(voxels, clusters[j], kTopPartShare);
      if (!layer) break;
      if (!other_layer || !AreOne(space,
                                  max_hidden_m,
                                  TopOf(voxels, clusters[i], *layer),
                                  TopOf(voxels, clusters[j], *other_layer))) {
        continue;
      }
      AddPart(clusters[j], &clusters[i]);
      clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(j));
      j = i;  // the larger top may reach others
    }
  }
  std::ranges::sort(clusters, {}, [](const Cluster& cluster) {
    return std::tuple(cluster.label, cluster.voxels.front());
  });
  return clusters;
}

}  // namespace nightmap
