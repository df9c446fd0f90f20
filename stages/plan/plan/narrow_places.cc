// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/narrow_places.h"

#include <limits>

namespace nightmap {
namespace {

constexpr double kRounding_m = 1e-9;

}  // namespace

std::vector<NarrowPlace> FindNarrowPlaces(const std::vector<PathPoint>& path,
                                          double robot_radius_m,
                                          double margin_m) {
  std::vector<NarrowPlace> places;
  bool is_inside = false;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double room_m = path[i].clearance_m - robot_radius_m;
    const bool was_inside = is_inside;
    is_inside = room_m < margin_m - kRounding_m;
    if (!is_inside) continue;
    if (!was_inside) {
      places.push_back({i, i, 0, path[i].point_in_map, std::numeric_limits<double>::infinity()});
    }
    NarrowPlace& place = places.back();
    place.last_point = i;
    place.length_m = path[i].distance_m - path[place.first_point].distance_m;
    if (room_m >= place.room_m - kRounding_m) continue;
    place.room_m = room_m;
    place.narrowest_in_map = path[i].point_in_map;
  }
  return places;
}

}  // namespace nightmap
