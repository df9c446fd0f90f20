// SPDX-License-Identifier: Apache-2.0
// Joins what was seen of one thing in parts.
#pragma once

#include <vector>

#include "stages/labels/things/clusters.h"
#include "stages/labels/things/upright_box.h"

namespace nightmap {

// A cluster is a part of a larger one of its class when most of its voxels lie in that one's
// completed box, a voxel of margin around it: something hid the space between them. `boxes` are
// those of the clusters. Returns the clusters with their parts, in order of class and first voxel.
std::vector<Cluster> JoinParts(const VoxelLabels& voxels,
                               const std::vector<Cluster>& clusters,
                               const std::vector<UprightBox>& boxes);

}  // namespace nightmap
