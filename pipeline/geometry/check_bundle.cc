// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/check_bundle.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

void CheckSizes(const BundleProblem& problem) {
  const std::size_t num_poses = problem.camera_from_world.size();
  if (problem.cameras.size() != num_poses || problem.is_fixed.size() != num_poses) {
    throw DataError("bundle adjustment: {} poses, {} cameras, {} flags",
                    num_poses,
                    problem.cameras.size(),
                    problem.is_fixed.size());
  }
  const auto& sensor_idx = problem.sensor_idx;
  const auto num_sensors = static_cast<int>(problem.calibrations.size());
  if (num_sensors == 0 || (!sensor_idx.empty() && sensor_idx.size() != num_poses) ||
      (!problem.motions.empty() && problem.motions.size() != num_poses) ||
      std::ranges::any_of(sensor_idx, [&](int i) { return i < 0 || i >= num_sensors; })) {
    throw DataError("bundle adjustment: {} calibrations and {} motions do not fit {} poses",
                    num_sensors,
                    problem.motions.size(),
                    num_poses);
  }
}

void CheckNumbers(const BundleProblem& problem) {
  for (const BundleObservation& o : problem.observations) {
    if (o.pixel.allFinite() && std::isfinite(o.depth_m)) continue;
    throw DataError(
        "bundle adjustment: pose {} sees point {} at a pixel or depth that is no number; {}",
        o.pose_idx,
        o.point_idx,
        kBundleRemedy);
  }
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    if (problem.camera_from_world[i].Matrix().allFinite()) continue;
    throw DataError("bundle adjustment: pose {} is no number; {}", i, kBundleRemedy);
  }
  for (std::size_t i = 0; i < problem.points_in_world.size(); ++i) {
    if (problem.points_in_world[i].allFinite()) continue;
    throw DataError("bundle adjustment: point {} is no number; {}", i, kBundleRemedy);
  }
}

}  // namespace

void CheckBundle(const BundleProblem& problem) {
  CheckSizes(problem);
  CheckNumbers(problem);
}

}  // namespace nightmap
