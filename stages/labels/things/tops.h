// SPDX-License-Identifier: Apache-2.0
// Tables and the like: flat tops on thin legs, with other things on them and before them.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/dense/voxel_labels_io.h"
#include "stages/labels/things/clusters.h"
#include "stages/labels/things/labelled_space.h"

namespace nightmap {

// Layer (z of its voxels) of the top of a thing that is little else: it and the layers beside it
// hold at least `min_share` of the thing's voxels, and next to nothing is above them. Nothing for
// other things.
std::optional<int> TopLayer(const VoxelLabels& voxels, const Cluster& cluster, double min_share);
constexpr double kTopShare = 0.5;       // of a whole thing
constexpr double kTopPartShare = 0.25;  // of a part of one, which may be a leg with a corner

// Joins clusters of one class whose tops are a layer apart at most, and between which a top may be:
// at most a tenth of the rectangle around both was seen free at the layer of the top, and they are
// at most max_hidden_m apart. Things on a table, or before it, hide or cover the rest.
// Returns the clusters in order of class and first voxel.
std::vector<Cluster> JoinTops(const VoxelLabels& voxels,
                              const LabelledSpace& space,
                              double max_hidden_m,
                              std::vector<Cluster> clusters);

}  // namespace nightmap
