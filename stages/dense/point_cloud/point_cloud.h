// SPDX-License-Identifier: Apache-2.0
// point_cloud: makes one cloud of the building from the depth of all keyframes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/dense/back_project.h"
#include "pipeline/dense/ply_io.h"
#include "pipeline/dense/rgbd_keyframes.h"
#include "stages/dense/point_cloud/held_out_rays.h"
#include "stages/dense/point_cloud/place_quality.h"

namespace nightmap {

struct PointCloudOptions {
  OPTION(int, keyframe_stride, 1, {1, 1000}, "uses every Nth keyframe");
  OPTION(double, max_depth_m, 4.0, {0.1, 100.0}, "farther depth is ignored");
  OPTIONS_OF(DepthFilterOptions, depth_filter);
  OPTION(double, voxel_size_m, 0.02, {0.002, 1.0},
         "edge of a voxel, which holds at most one point");
  OPTION(int, min_observations, 2, {1, 10000}, "depth pixels that a voxel needs");
  OPTION(int, min_consistent_frames, 1, {0, 1000},
         "keyframes that must confirm a voxel; they must also be as many as those that see through "
         "it; 0: no check");
  OPTION(double, consistency_sigmas, 3.0, {0.5, 20.0},
         "depths agree when they differ by less than this many sigma of their noise plus a voxel");
  OPTION(double, outlier_radius_voxels, 3.0, {1.0, 20.0},
         "radius in which an outlier has few neighbours");
  OPTION(int, outlier_min_neighbors, 12, {0, 1000},
         "a voxel with fewer neighbours in this radius is an outlier; 0 keeps outliers");
  OPTION(double, surface_radius_m, 0.08, {0.005, 2.0},
         "radius of the neighbourhood that gives a point's normal and projection");
  OPTION(bool, project_to_surface, true, "moves points onto the plane of their neighbourhood");
  REGISTER_OPTIONS();
};

struct PointCloudResult {
  std::vector<CloudPoint> points;    // in the map frame, ordered by voxel
  std::vector<std::string> skipped;  // one reason for each keyframe left out
  // These count within the requested part of the map:
  std::size_t num_measurements = 0;  // depth pixels fused
  std::size_t num_voxels = 0;        // with enough observations, before any removal
  std::size_t num_inconsistent = 0;  // voxels that other keyframes contradict
  std::size_t num_outliers = 0;
  // Standard deviation of the fused points from the planes around them, before projection: median
  // and 90th percentile. 0 where nothing is flat.
  double plane_thickness_median_m = 0;
  double plane_thickness_p90_m = 0;
  RayAgreement held_out;             // for sampled rays that end in this part
  std::vector<PlaceQuality> places;  // the same by place
};

// Back-projects every keyframe and averages the points of each voxel, weighted by 1 / sigma^2 of
// the depth noise (colors unweighted). Removes outliers and points that other keyframes contradict,
// fits the surface and averages by voxel once more: at most one point per voxel. Memory grows with
// the surface of the source's region, not with the keyframes. Each step looks at a bounded
// neighbourhood in a fixed order, so the clouds of a site's regions equal the whole cloud, bit for
// bit. Same result at any number of threads. Throws UsageError when the region overlaps by less
// than that neighbourhood.
PointCloudResult RunPointCloud(const PointCloudOptions& options,
                               const KeyframeSource& source,
                               Progress& progress,
                               int num_threads);

}  // namespace nightmap
