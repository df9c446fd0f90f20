// SPDX-License-Identifier: Apache-2.0
// Reference implementation by OctoMap's own insertion; tests and benchmarks compare OccupancyVolume
// with it.
#pragma once

#include <memory>

#include "pipeline/dense/octree_io.h"
#include "stages/dense/octree/sensor_model.h"
#include "stages/dense/octree/trace_rays.h"

namespace nightmap {

class OctomapVolume {
 public:
  OctomapVolume(const SensorModel& model, const TraceOptions& options);
  ~OctomapVolume();

  // insertPointCloud with lazy evaluation. Ignores margins and colors, which OctoMap does not have;
  // with `discretize` a voxel's ray starts from the voxel's centre.
  void Insert(const KeyframeRays& rays);

  // The tree's leaves in the options' region, without colors, as OccupancyVolume chooses them. Lazy
  // evaluation leaves all leaves at the smallest size. They are pruned as OccupancyVolume's are:
  // free ones here, all of them on writing.
  OccupancyTree Leaves();

 private:
  class Tree;
  float threshold_;
  TraceOptions options_;
  std::unique_ptr<Tree> tree_;
};

}  // namespace nightmap
