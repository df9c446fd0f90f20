// SPDX-License-Identifier: Apache-2.0
// Takes apart what stands side by side and differs in height.
#pragma once

#include <vector>

#include "pipeline/dense/voxel_labels_io.h"
#include "stages/labels/things/clusters.h"
#include "stages/labels/things/labelled_space.h"

namespace nightmap {

// Shelves in a row touch, but each has a top of its own. Cuts a cluster across its longer side
// where the height of its highest voxels makes a step of at least two layers, when most of the 1 m
// on both sides of it, or of all that is there, but 0.65 m at least, keeps its height, and the
// space above the lower side was seen free: what the cameras did not look up to is no top. Returns
// the parts, along the longer side, or the cluster alone. Deterministic.
std::vector<Cluster> SplitSteps(const VoxelLabels& voxels,
                                const LabelledSpace& space,
                                const Cluster& cluster);

}  // namespace nightmap
