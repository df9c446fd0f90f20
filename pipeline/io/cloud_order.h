// SPDX-License-Identifier: Apache-2.0
// Order of the points in a cloud file; clouds of tiles are merged in this order.
#pragma once

#include "pipeline/io/ply_io.h"

namespace nightmap {

// By voxel, then by position.
bool ByVoxel(const CloudPoint& a, const CloudPoint& b, double voxel_size_m);

}  // namespace nightmap
