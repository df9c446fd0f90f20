// SPDX-License-Identifier: Apache-2.0
// Clusters that are no things.
#pragma once

#include <array>
#include <vector>

#include "pipeline/dense/voxel_labels_io.h"
#include "stages/labels/things/clusters.h"
#include "stages/labels/things/labelled_space.h"

namespace nightmap {

// Whether a cluster is a stain: a few layers of a floor, whose voxels at its rim go on in others,
// at their height or one layer off, that are of no class of a thing (`is_thing_class`). Things on
// the floor rise above their surroundings, and things on a table have things around them.
bool IsStain(const VoxelLabels& voxels,
             const LabelledSpace& space,
             const std::array<bool, 256>& is_thing_class,
             const Cluster& cluster);

// Whether a cluster is a leg alone: two voxels wide at most, and four times as high. The thing that
// it belongs to was not seen, or has another class.
bool IsLeg(const VoxelLabels& voxels, const Cluster& cluster);

}  // namespace nightmap
