// SPDX-License-Identifier: Apache-2.0
// How good a cloud is by place, so that people see where it is not: thickness of flat surfaces and
// agreement of held-out rays in cubes of half a metre.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace nightmap {

constexpr double kPlaceSize_m = 0.5;

struct PlaceQuality {
  Eigen::Vector3d centre_in_map = Eigen::Vector3d::Zero();
  std::size_t num_flat = 0;      // flat points
  double thickness_m = 0;        // median of theirs; 0 without any
  std::size_t num_rays = 0;      // held-out rays that end here
  std::size_t num_agreeing = 0;  // of them
};

class PlaceQualities {
 public:
  void AddFlat(const Eigen::Vector3d& point_in_map, float thickness_m);
  void AddRay(const Eigen::Vector3d& end_in_map, bool is_agreeing);

  // Ordered by x, then y, then z, whatever the order of adding.
  std::vector<PlaceQuality> Places() const;

 private:
  struct Sums {
    std::vector<float> thickness_m;
    std::size_t num_rays = 0;
    std::size_t num_agreeing = 0;
  };
  std::map<std::uint64_t, Sums> of_place_;  // by packed key
};

// places_X_Y.csv: x_m, y_m, z_m of the cube's centre in the map frame, num_flat, thickness_m (empty
// without flat points), num_rays, num_rays_agreeing.
std::string PlacesToCsv(const std::vector<PlaceQuality>& places);

}  // namespace nightmap
