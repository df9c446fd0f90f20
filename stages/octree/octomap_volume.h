// SPDX-License-Identifier: Apache-2.0
// The reference: OctoMap's own insertion, which tests and benchmarks compare OccupancyVolume with.
#pragma once

#include <memory>

#include "pipeline/io/octree_io.h"
#include "stages/octree/scan.h"
#include "stages/octree/sensor_model.h"

namespace nightmap {

class OctomapVolume {
 public:
  OctomapVolume(const SensorModel& model, const ScanOptions& options);
  ~OctomapVolume();

  // insertPointCloud with lazy evaluation. Margins and colors are not OctoMap's and count for
  // nothing; with `discretize` the ray of a voxel is from its centre.
  void Insert(const Scan& scan);

  // What of the tree is in the options' region, without colors. Lazy evaluation leaves all leaves
  // of the smallest size; they are pruned as ours: the free ones here, all when they are written.
  OccupancyTree Leaves();

 private:
  class Tree;
  ScanOptions options_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace nightmap
