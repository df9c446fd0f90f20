// SPDX-License-Identifier: Apache-2.0
// point_cloud: one cloud of the building from the depth of all keyframes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/ply_io.h"
#include "pipeline/vision/back_project.h"
#include "pipeline/vision/rgbd_keyframes.h"

namespace nightmap {

struct PointCloudOptions {
  int keyframe_stride = 1;
  double max_depth_m = 4.0;
  DepthFilterOptions depth_filter;
  double voxel_size_m = 0.02;
  int min_observations = 2;
  int outlier_neighbors = 16;
  double outlier_deviations = 2.0;
  double surface_radius_m = 0.08;
  bool project_to_surface = true;
  double max_failed_ratio = 0.05;

  void Register(OptionList& list);
};

struct PointCloudResult {
  std::vector<CloudPoint> points;    // in the map frame, by voxel
  std::vector<std::string> skipped;  // one reason for each keyframe left out
  std::size_t num_measurements = 0;  // depth pixels fused
  std::size_t num_voxels = 0;        // with enough observations, before outlier removal
  std::size_t num_outliers = 0;
};

// Back-projects every keyframe, averages the points of each voxel weighted by 1 / sigma^2 of the
// depth noise (colors plainly), removes outliers, fits the surface and averages by voxel once more:
// at most one point a voxel. Memory grows with the surface mapped, not with the keyframes. Same
// result at any number of threads. Throws DataError when nothing was measured.
PointCloudResult RunPointCloud(const PointCloudOptions& options,
                               const KeyframeSource& source,
                               Progress& progress,
                               int num_threads);

}  // namespace nightmap
