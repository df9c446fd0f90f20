// SPDX-License-Identifier: Apache-2.0
// Octrees of made-up buildings, seen from exact poses.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pipeline/geometry/camera.h"
#include "pipeline/world/synthetic_world.h"
#include "tests/stages/dense/grid/room.h"

namespace nightmap {

// The voxels that rays from the poses pass and hit; hits win.
class Carver {
 public:
  Carver(const Eigen::Vector3d& low, const Eigen::Vector3d& high)
      : low_((low / kResolution_m).array().floor().cast<int>()),
        size_(((high - low) / kResolution_m).array().ceil().cast<int>()),
        states_(static_cast<std::size_t>(size_.prod()), kUnseen) {}

  void Look(const SyntheticWorld& world, const Rigid3& pose, const Camera& camera) {
    constexpr double kReach_m = 4;
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const Eigen::Vector3d ray =
            pose.rotation * camera.BackProject(Eigen::Vector2d(x, y), 1.0).normalized();
        const RayHit hit = world.rays->Cast(pose.translation, ray);
        const double end_m = hit.surface_idx < 0 ? kReach_m : std::min(hit.distance, kReach_m);
        for (double m = 0.3; m < end_m - 0.03; m += kResolution_m / 2) {
          Mark(pose.translation + m * ray, kPassed);
        }
        if (end_m < kReach_m) Mark(pose.translation + (end_m + 1e-6) * ray, kHit);
      }
    }
  }

  OccupancyTree Tree() const {
    OccupancyTree tree{kResolution_m, {}};
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (states_[i] == kUnseen) continue;
      const auto index = static_cast<int>(i);
      const Eigen::Vector3i key = low_ + Eigen::Vector3i(index % size_.x(),
                                                         index / size_.x() % size_.y(),
                                                         index / size_.x() / size_.y());
      const Eigen::Vector3d centre = kResolution_m * (key.cast<double>().array() + 0.5);
      tree.leaves.push_back(VoxelRoom::Leaf(centre, kResolution_m, states_[i] == kHit));
    }
    return tree;
  }

 private:
  enum State : std::uint8_t { kUnseen, kPassed, kHit };

  void Mark(const Eigen::Vector3d& point, State state) {
    const Eigen::Vector3i at = (point / kResolution_m).array().floor().cast<int>() - low_.array();
    if ((at.array() < 0).any() || (at.array() >= size_.array()).any()) return;
    auto& voxel =
        states_[static_cast<std::size_t>(at.x() + size_.x() * (at.y() + size_.y() * at.z()))];
    voxel = std::max<std::uint8_t>(voxel, state);
  }

  Eigen::Vector3i low_, size_;
  std::vector<std::uint8_t> states_;
};

}  // namespace nightmap
