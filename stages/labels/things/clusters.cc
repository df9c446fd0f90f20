// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/clusters.h"

// The template itself: the library segmentation, which has it for these points too, brings many
// others along.
#include <pcl/segmentation/impl/extract_clusters.hpp>

#include <algorithm>
#include <iterator>
#include <limits>
#include <memory>

#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

using Cloud = pcl::PointCloud<pcl::PointXYZ>;

// Coordinates are in voxels, which floats hold exactly.
Cloud::Ptr CloudOf(const VoxelLabels& voxels, const std::vector<std::size_t>& indices) {
  auto cloud = std::make_shared<Cloud>();
  for (const std::size_t i : indices) {
    const Eigen::Vector3f point = voxels.keys[i].cast<float>();
    cloud->emplace_back(point.x(), point.y(), point.z());
  }
  return cloud;
}

std::vector<Cluster> ClustersOfClass(const ClusterOptions& options,
                                     const VoxelLabels& voxels,
                                     std::uint8_t label,
                                     const std::vector<std::size_t>& indices) {
  std::vector<Cluster> clusters;
  if (indices.empty()) return clusters;
  const auto tree = std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>(false);
  const Cloud::Ptr cloud = CloudOf(voxels, indices);
  tree->setInputCloud(cloud);
  std::vector<pcl::PointIndices> groups;
  pcl::extractEuclideanClusters<pcl::PointXYZ>(*cloud,
                                               tree,
                                               static_cast<float>(options.tolerance_voxels),
                                               groups,
                                               static_cast<unsigned>(options.min_voxels),
                                               std::numeric_limits<unsigned>::max());
  for (const pcl::PointIndices& group : groups) {
    Cluster& cluster = clusters.emplace_back();
    cluster.label = label;
    for (const int i : group.indices) {
      cluster.voxels.push_back(indices[static_cast<std::size_t>(i)]);
    }
    std::ranges::sort(cluster.voxels);
    double sum = 0;
    for (const std::size_t i : cluster.voxels) sum += LabelOf(voxels, i).share;
    cluster.mean_share = sum / static_cast<double>(cluster.voxels.size());
  }
  std::ranges::sort(clusters, {}, [](const Cluster& cluster) { return cluster.voxels.front(); });
  return clusters;
}

}  // namespace

void AddPart(const Cluster& part, Cluster* whole) {
  const auto num_whole = static_cast<double>(whole->voxels.size());
  const auto num_part = static_cast<double>(part.voxels.size());
  whole->mean_share =
      (num_whole * whole->mean_share + num_part * part.mean_share) / (num_whole + num_part);
  whole->voxels.insert(whole->voxels.end(), part.voxels.begin(), part.voxels.end());
  std::ranges::sort(whole->voxels);
}

std::vector<Cluster> FindClusters(const ClusterOptions& options,
                                  const VoxelLabels& voxels,
                                  int num_threads) {
  std::vector<std::vector<std::size_t>> voxels_of_class(256);
  for (std::size_t i = 0; i < voxels.Size(); ++i) {
    const VoxelLabel label = LabelOf(voxels, i);
    if (label.share >= options.min_share) voxels_of_class[label.label].push_back(i);
  }
  std::vector<std::vector<Cluster>> found(options.labels.size());
  ParallelFor(found.size(), num_threads, [&](std::size_t i) {
    const std::uint8_t label = options.labels[i];
    found[i] = ClustersOfClass(options, voxels, label, voxels_of_class[label]);
  });
  std::vector<Cluster> clusters;
  for (std::vector<Cluster>& of_class : found)
    std::ranges::move(of_class, std::back_inserter(clusters));
  return clusters;
}

}  // namespace nightmap
