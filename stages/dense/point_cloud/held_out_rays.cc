// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/held_out_rays.h"

#include <algorithm>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

constexpr std::size_t kRaysPerJob = 64;

class RayTest {
 public:
  RayTest(const HeldOutRay& ray, const VoxelSums& cloud, double voxel_size_m)
      : ray_(ray),
        cloud_(cloud),
        voxel_size_m_(voxel_size_m),
        length_m_((ray.end - ray.origin).norm()),
        direction_((ray.end - ray.origin) / length_m_) {}

  bool IsBlocked() const {
    const double step_m = 0.5 * voxel_size_m_;
    for (double at_m = step_m; at_m < length_m_ - ray_.tolerance_m; at_m += step_m) {
      const VoxelSum* voxel = Find(VoxelAt(at_m));
      if (voxel != nullptr && Blocks(*voxel)) return true;
    }
    return false;
  }

  bool EndsOnTheCloud() const {
    const double last_m = length_m_ + ray_.tolerance_m;
    for (double at_m = length_m_ - ray_.tolerance_m; at_m <= last_m; at_m += voxel_size_m_) {
      const VoxelKey key = VoxelAt(at_m);
      for (int i = 0; i < 27; ++i) {
        const VoxelSum* voxel = Find(key + VoxelKey(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1));
        if (voxel != nullptr && std::abs(HeightOfEnd_m(*voxel)) <= ray_.tolerance_m) return true;
      }
    }
    return false;
  }

 private:
  VoxelKey VoxelAt(double at_m) const {
    return VoxelOf(ray_.origin + at_m * direction_, voxel_size_m_);
  }

  // Null when no voxel there was measured by another fold.
  const VoxelSum* Find(const VoxelKey& key) const {
    const auto found = cloud_.find(PackVoxel(key));
    const bool is_known = found != cloud_.end() && (found->second.folds & ~ray_.fold) != 0;
    return is_known ? &found->second : nullptr;
  }

  // Height above the plane of a point, on the side of its cameras.
  double HeightOfEnd_m(const VoxelSum& voxel) const {
    return voxel.direction.cast<double>().normalized().dot(ray_.end - voxel.Position());
  }

  bool Blocks(const VoxelSum& voxel) const {
    const Eigen::Vector3d offset = voxel.Position() - ray_.origin;
    const double beside_m = (offset - offset.dot(direction_) * direction_).norm();
    return beside_m < 0.5 * voxel_size_m_ && HeightOfEnd_m(voxel) < -ray_.tolerance_m;
  }

  const HeldOutRay& ray_;
  const VoxelSums& cloud_;
  double voxel_size_m_;
  double length_m_;
  Eigen::Vector3d direction_;
};

}  // namespace

std::vector<RayEnd> TestRays(const std::vector<HeldOutRay>& rays,
                             const VoxelSums& cloud,
                             double voxel_size_m,
                             int num_threads) {
  std::vector<RayEnd> ends(rays.size());
  const std::size_t num_jobs = (rays.size() + kRaysPerJob - 1) / kRaysPerJob;
  ParallelFor(num_jobs, num_threads, [&](std::size_t job) {
    const std::size_t end = std::min((job + 1) * kRaysPerJob, rays.size());
    for (std::size_t i = job * kRaysPerJob; i < end; ++i) {
      const RayTest test(rays[i], cloud, voxel_size_m);
      ends[i] = test.IsBlocked()        ? RayEnd::kBlocked
                : test.EndsOnTheCloud() ? RayEnd::kOnTheCloud
                                        : RayEnd::kNowhere;
    }
  });
  return ends;
}

RayAgreement AgreementOf(const std::vector<RayEnd>& ends) {
  const auto count = [&](RayEnd end) {
    return static_cast<std::size_t>(std::ranges::count(ends, end));
  };
  return {ends.size(), count(RayEnd::kOnTheCloud), count(RayEnd::kBlocked)};
}

}  // namespace nightmap
