// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/objects/objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/parallel.h"
#include "pipeline/laser/search_pose.h"
#include "stages/laser/objects/places.h"

namespace nightmap {
namespace {

// A place has so much wall across the direction in which a scan slides best.
constexpr double kMinWall_m = 0.4;
// So large a share of a place's occupied cells is beside free ones.
constexpr double kMinSeenShare = 0.7;
constexpr int kNumLevels = 8;  // of the pyramid: up to squares of 128 cells
// Places nearer than this share of their size to a better one show the same walls.
constexpr double kSamePlace = 0.25;

// The likelihood field of the whole map. Its side is an odd number of cells, so that its middle is
// a cell's, and the search tries a place's own position exactly.
class WholeMap {
 public:
  WholeMap(const OccupancyGrid& grid, double sigma_m)
      : cell_m_(grid.resolution_m),
        side_(std::max(grid.width, grid.height) | 1),
        field_({cell_m_, HalfExtent_m(), sigma_m}),
        pyramid_(Filled(grid), kNumLevels) {}

  // The best score of a place's occupied cells anywhere else.
  double BestElsewhere(const Place& place, double near_m) const {
    std::vector<Eigen::Vector2d> points;
    for (const Eigen::Vector2i& cell : place.cells) {
      points.push_back(cell_m_ * (cell - place.center).cast<double>());
    }
    SearchWindow window;
    window.half_extent_m = HalfExtent_m();
    window.half_angle_rad = std::numbers::pi;
    window.not_near = Rigid2{0, InField(place.center)};
    window.near_m = near_m;
    window.near_rad = 2 * std::numbers::pi;  // the same place at another heading is no other
    const auto found = SearchPose(pyramid_, points, window);
    return found ? found->score : 0;
  }

 private:
  double HalfExtent_m() const { return 0.5 * side_ * cell_m_; }

  Eigen::Vector2d InField(const Eigen::Vector2i& cell) const {
    return cell_m_ * (cell.cast<double>().array() - (side_ / 2));
  }

  const LikelihoodField& Filled(const OccupancyGrid& grid) {
    std::vector<Eigen::Vector2d> points;
    for (Eigen::Vector2i cell(0, 0); cell.y() < grid.height; ++cell.y()) {
      for (cell.x() = 0; cell.x() < grid.width; ++cell.x()) {
        if (grid.At(cell) == kOccupiedCell) points.push_back(InField(cell));
      }
    }
    field_.Add(points);
    return field_;
  }

  double cell_m_;
  int side_;
  LikelihoodField field_;
  FieldPyramid pyramid_;
};

// Keeps those in front that are farther than a distance, in cells, from all that are kept.
std::vector<Place> KeepApart(std::vector<Place> places, double distance, std::size_t max_count) {
  std::vector<Place> kept;
  for (Place& place : places) {
    if (kept.size() == max_count) break;
    const auto is_near = [&](const Place& other) {
      return (place.center - other.center).cast<double>().norm() < distance;
    };
    if (std::ranges::none_of(kept, is_near)) kept.push_back(std::move(place));
  }
  return kept;
}

double Rounded(double value, double steps_per_unit) {
  return std::round(value * steps_per_unit) / steps_per_unit + 0.0;
}

// The box of the place's occupied cells along its walls.
MapObject BoxOf(const OccupancyGrid& grid, const Place& place) {
  const Eigen::Rotation2Dd turn(place.heading_rad);
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2i& cell : place.cells) box.extend(turn.inverse() * cell.cast<double>());
  MapObject object;
  const Eigen::Vector2d center =
      grid.FromCells(turn * box.center() + Eigen::Vector2d::Constant(0.5));
  object.map_from_object.translation = {Rounded(center.x(), 100), Rounded(center.y(), 100)};
  const double heading_deg =
      WrapAngle_rad(place.heading_rad + grid.origin_yaw_rad) * 180 / std::numbers::pi;
  object.map_from_object.heading_rad = Rounded(heading_deg, 10) * std::numbers::pi / 180;
  const Eigen::Vector2d size_m = grid.resolution_m * (box.sizes().array() + 1);
  object.size_m = {Rounded(size_m.x(), 100), Rounded(size_m.y(), 100)};
  object.distinctiveness = place.distinctiveness;
  return object;
}

}  // namespace

ObjectsResult RunObjects(const ObjectsOptions& options,
                         const OccupancyGrid& grid,
                         Progress& progress,
                         int num_threads) {
  const double radius = options.size_m / 2 / grid.resolution_m;
  std::vector<Place> places = FindPlaces(grid, radius, kMinWall_m / grid.resolution_m, num_threads);
  std::erase_if(places, [&](const Place& place) {
    return place.straightness < options.min_straightness || place.seen_share < kMinSeenShare;
  });
  const std::size_t num_found = places.size();
  places = KeepApart(std::move(places), kSamePlace * 2 * radius, num_found);
  ObjectsResult result;
  result.num_places = places.size();
  const WholeMap map(grid, options.sigma_m);
  progress.Start(places.size());
  ParallelFor(places.size(), num_threads, [&](std::size_t i) {
    places[i].distinctiveness = Rounded(1 - map.BestElsewhere(places[i], options.size_m / 2), 1000);
    progress.Advance();
  });
  progress.Finish();
  std::erase_if(places, [&](const Place& place) {
    return place.distinctiveness < options.min_distinctiveness;
  });
  result.num_distinctive = places.size();
  std::ranges::stable_sort(places, std::ranges::greater(), &Place::distinctiveness);
  for (const Place& place : KeepApart(std::move(places),
                                      options.min_distance_m / grid.resolution_m,
                                      static_cast<std::size_t>(options.max_objects))) {
    result.objects.push_back(BoxOf(grid, place));
    result.objects.back().name = fmt::format("object {}", result.objects.size());
  }
  result.notices = ClampObjects(options.max_object_size_m, &result.objects);
  return result;
}

nlohmann::json DescribeObjects(const ObjectsResult& result) {
  nlohmann::json json = {{"num_places", result.num_places},
                         {"num_distinctive_places", result.num_distinctive},
                         {"num_objects", result.objects.size()},
                         {"num_cut_objects", result.notices.size()}};
  if (!result.objects.empty()) {
    json["largest_distinctiveness"] = *result.objects.front().distinctiveness;
    json["smallest_distinctiveness"] = *result.objects.back().distinctiveness;
  }
  return json;
}

}  // namespace nightmap
