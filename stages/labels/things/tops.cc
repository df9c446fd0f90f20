// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/tops.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <tuple>

#include "stages/labels/things/upright_box.h"

namespace nightmap {
namespace {

constexpr double kMaxAboveShare = 0.05;  // of a thing's voxels that may be above its top
constexpr double kMaxFreeShare = 0.1;    // of the rectangle around two parts of a top

using Points = std::vector<Eigen::Vector3d>;

struct Top {
  int layer = 0;
  Points points;  // centres of the voxels of this layer and those beside it
  Eigen::AlignedBox2d around;
};

std::optional<Top> TopOf(const VoxelLabels& voxels, const Cluster& cluster) {
  const auto layer = TopLayer(voxels, cluster, kTopPartShare);
  if (!layer) return std::nullopt;
  Top top{*layer, {}, {}};
  for (const std::size_t i : cluster.voxels) {
    if (std::abs(voxels.keys[i].z() - *layer) > 1) continue;
    top.points.push_back(VoxelCentre(voxels.keys[i], voxels.resolution_m));
    top.around.extend(Eigen::Vector2d(top.points.back().head<2>()));
  }
  return top;
}

bool AreNear(const Top& a, const Top& b, double distance_m) {
  if (a.around.exteriorDistance(b.around) > distance_m) return false;
  return std::ranges::any_of(a.points, [&](const Eigen::Vector3d& point) {
    return std::ranges::any_of(b.points, [&](const Eigen::Vector3d& other) {
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
  if (std::abs(a.layer - b.layer) > 1 || !AreNear(a, b, max_hidden_m)) return false;
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
  std::vector<std::optional<Top>> tops;
  for (const Cluster& cluster : clusters) tops.push_back(TopOf(voxels, cluster));
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    for (std::size_t j = i + 1; j < clusters.size() && tops[i]; ++j) {
      if (clusters[j].label != clusters[i].label) break;
      if (!tops[j] || !AreOne(space, max_hidden_m, *tops[i], *tops[j])) continue;
      AddPart(clusters[j], &clusters[i]);
      clusters.erase(clusters.begin() + static_cast<std::ptrdiff_t>(j));
      tops.erase(tops.begin() + static_cast<std::ptrdiff_t>(j));
      tops[i] = TopOf(voxels, clusters[i]);
      j = i;  // the larger top may reach others
    }
  }
  std::ranges::sort(clusters, {}, [](const Cluster& cluster) {
    return std::tuple(cluster.label, cluster.voxels.front());
  });
  return clusters;
}

}  // namespace nightmap
