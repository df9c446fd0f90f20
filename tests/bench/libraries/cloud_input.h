// SPDX-License-Identifier: Apache-2.0
// The depth that clouds are made of: of a map's keyframes, or of a made-up box room whose walls are
// known.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "stages/dense/point_cloud/point_cloud.h"
#include "stages/dense/point_cloud/voxel_filter.h"
#include "tests/bench/libraries/mapped_site.h"
#include "tests/stages/dense/point_cloud/box_room.h"

namespace nightmap {

using DepthPoints = std::vector<std::vector<VoxelSum>>;  // of each keyframe, one per pixel

struct CloudInput {
  std::string name;
  DepthPoints keyframes;
  std::optional<BoxRoom> room;
};

CloudInput CloudOfSite(const MappedSite& site);
CloudInput CloudOfBoxRoom();

// As the stage: a sum per keyframe, which several threads make, and then their sum in order.
SortedVoxels Fuse(const DepthPoints& keyframes, const PointCloudOptions& options, int num_threads);

// From the walls of the room.
double RmsDistance_mm(const BoxRoom& room, const std::vector<Eigen::Vector3d>& points);
// Normal of the nearest wall, up to its sign.
Eigen::Vector3f WallNormal(const BoxRoom& room, const Eigen::Vector3d& point);

}  // namespace nightmap
