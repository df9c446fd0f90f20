// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/libraries/landmark_problem.h"

#include <algorithm>

#include "pipeline/base/random.h"

namespace nightmap {

BundleProblem MakeLandmarkProblem(const MappedSite& site) {
  BundleProblem problem;
  for (const MapKeyframe& keyframe : site.landmarks.keyframes) {
    problem.camera_from_world.push_back(keyframe.map_from_camera.Inverse());
    problem.cameras.push_back(site.CameraOf(keyframe.frame_idx).color);
    problem.is_fixed.push_back(problem.is_fixed.empty());
  }
  problem.points_in_world = site.landmarks.positions_in_map;
  for (std::size_t k = 0; k < site.landmarks.landmark_keyframes.size(); ++k) {
    for (std::size_t i = 0; i < site.landmarks.landmark_keyframes[k].size(); ++i) {
      const int pose_idx = site.landmarks.landmark_keyframes[k][i];
      const int frame_idx = site.landmarks.keyframes[static_cast<std::size_t>(pose_idx)].frame_idx;
      const FeatureView feature =
          site.FeaturesOf(frame_idx).Feature(site.landmarks.landmark_features[k][i]);
      problem.observations.push_back({pose_idx,
                                      static_cast<int>(k),
                                      feature.Pixel(),
                                      feature.Depth_m(),
                                      site.CameraOf(frame_idx).noise});
    }
  }
  return problem;
}

void Disturb(BundleProblem* problem) {
  Random random(1);
  const auto noise = [&] {
    return Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian());
  };
  for (std::size_t i = 1; i < problem->camera_from_world.size(); ++i) {
    Vector6d step;
    step << 0.005 * noise(), 0.01 * noise();
    problem->camera_from_world[i] = PerturbLeft(step, problem->camera_from_world[i]);
  }
  for (Eigen::Vector3d& point : problem->points_in_world) point += 0.02 * noise();
}

double LargestShift_mm(const std::vector<Rigid3>& a, const std::vector<Rigid3>& b) {
  double largest_m = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Rigid3 difference = a[i].Inverse() * b[i];
    largest_m = std::max(largest_m, difference.translation.norm());
  }
  return 1e3 * largest_m;
}

}  // namespace nightmap
