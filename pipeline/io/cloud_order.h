// SPDX-License-Identifier: Apache-2.0
// The order of the points of a cloud file, in which clouds of tiles are merged to the whole one.
#pragma once

#include "pipeline/io/ply_io.h"

namespace nightmap {

// By voxel, then by position.
bool ByVoxel(const CloudPoint& a, const CloudPoint& b, double voxel_size_m);

}  // namespace nightmap
