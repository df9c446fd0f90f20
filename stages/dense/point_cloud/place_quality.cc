// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/place_quality.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

std::uint64_t PlaceOf(const Eigen::Vector3d& point_in_map) {
  return PackVoxel(VoxelOf(point_in_map, kPlaceSize_m));
}

}  // namespace

void PlaceQualities::AddFlat(const Eigen::Vector3d& point_in_map, float thickness_m) {
  of_place_[PlaceOf(point_in_map)].thickness_m.push_back(thickness_m);
}

void PlaceQualities::AddRay(const Eigen::Vector3d& end_in_map, bool is_agreeing) {
  Sums& sums = of_place_[PlaceOf(end_in_map)];
  ++sums.num_rays;
  sums.num_agreeing += is_agreeing ? 1 : 0;
}

std::vector<PlaceQuality> PlaceQualities::Places() const {
  std::vector<PlaceQuality> places;
  for (const auto& [key, sums] : of_place_) {
    std::vector<float> sorted_m = sums.thickness_m;
    std::ranges::sort(sorted_m);
    const double median_m = sorted_m.empty() ? 0.0 : sorted_m[sorted_m.size() / 2];
    places.push_back({VoxelCentre(UnpackVoxel(key), kPlaceSize_m),
                      sorted_m.size(),
                      median_m,
                      sums.num_rays,
                      sums.num_agreeing});
  }
  return places;
}

std::string PlacesToCsv(const std::vector<PlaceQuality>& places) {
  std::string csv = "x_m,y_m,z_m,num_flat,thickness_m,num_rays,num_rays_agreeing\n";
  for (const PlaceQuality& place : places) {
    csv += fmt::format("{:.2f},{:.2f},{:.2f},{},{},{},{}\n",
                       place.centre_in_map.x(),
                       place.centre_in_map.y(),
                       place.centre_in_map.z(),
                       place.num_flat,
                       place.num_flat > 0 ? fmt::format("{:.4f}", place.thickness_m) : "",
                       place.num_rays,
                       place.num_agreeing);
  }
  return csv;
}

}  // namespace nightmap
