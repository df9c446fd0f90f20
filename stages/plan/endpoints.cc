// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/endpoints.h"

#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "stages/plan/pictures.h"

namespace nightmap {
namespace {

const std::string kPicturePrefix = "picture:";

struct Candidate {
  Eigen::Vector2i cell = Eigen::Vector2i::Zero();
  double distance_m = std::numeric_limits<double>::infinity();
};

// Nearest free cell for each label of LabelReachable.
using Candidates = std::map<std::int32_t, Candidate>;

std::string ToText(const Eigen::Vector2d& point_m) {
  return fmt::format("{:.3f},{:.3f}", point_m.x(), point_m.y());
}

// Free cells within a radius, the point's own cell at distance 0 whatever its centre.
Candidates CellsWithin(const OccupancyGrid& grid,
                       const CostMap& map,
                       const std::vector<std::int32_t>& labels,
                       const Eigen::Vector2d& point_in_map,
                       double radius_m) {
  Candidates candidates;
  const Eigen::Vector2i own = grid.CellOf(point_in_map);
  const int reach = static_cast<int>(std::ceil(radius_m / grid.resolution_m)) + 1;
  for (int y = own.y() - reach; y <= own.y() + reach; ++y) {
    for (int x = own.x() - reach; x <= own.x() + reach; ++x) {
      const Eigen::Vector2i cell(x, y);
      if (!map.IsFree(cell)) continue;
      const double distance_m = cell == own ? 0 : (grid.CenterInMap(cell) - point_in_map).norm();
      Candidate& best = candidates[labels.empty() ? 1 : labels[map.Index(cell)]];
      if (distance_m <= radius_m && distance_m < best.distance_m) best = {cell, distance_m};
    }
  }
  std::erase_if(candidates, [](const auto& item) { return std::isinf(item.second.distance_m); });
  return candidates;
}

std::optional<Candidate> Nearest(const Candidates& candidates) {
  std::optional<Candidate> nearest;
  for (const auto& [label, candidate] : candidates) {
    if (!nearest || candidate.distance_m < nearest->distance_m) nearest = candidate;
  }
  return nearest;
}

// Nearest free cell of the whole grid.
std::optional<Candidate> NearestFree(const OccupancyGrid& grid,
                                     const CostMap& map,
                                     const Eigen::Vector2d& point_in_map) {
  std::optional<Candidate> nearest;
  for (std::size_t i = 0; i < map.Size(); ++i) {
    if (map.costs[i] == 0) continue;
    const Eigen::Vector2i cell = map.Cell(i);
    const double distance_m = (grid.CenterInMap(cell) - point_in_map).norm();
    if (!nearest || distance_m < nearest->distance_m) nearest = Candidate{cell, distance_m};
  }
  return nearest;
}

std::string WhyNotFree(const OccupancyGrid& grid, const CostMap& map, const Eigen::Vector2i& cell) {
  if (!grid.Contains(cell)) {
    const Eigen::Vector2d end =
        grid.origin_in_map + grid.resolution_m * Eigen::Vector2d(grid.width, grid.height);
    return fmt::format(
        "is outside of the map, which spans {} to {}", ToText(grid.origin_in_map), ToText(end));
  }
  if (grid.At(cell) == kOccupiedCell) return "is inside an obstacle";
  if (map.squared_distances[map.Index(cell)] == 0) return "is in unknown space";
  return fmt::format("is {:.3f} m from an obstacle or unknown space, nearer than robot_radius_m",
                     map.Clearance_m(cell));
}

[[noreturn]] void FailNotFree(const OccupancyGrid& grid,
                              const CostMap& map,
                              const EndpointRequest& request,
                              double snap_radius_m) {
  const auto nearest = NearestFree(grid, map, request.point_in_map);
  const std::string remedy = nearest
                                 ? fmt::format("the nearest free cell is {:.2f} m away at \"{}\"",
                                               nearest->distance_m,
                                               ToText(grid.CenterInMap(nearest->cell)))
                                 : "the map has no cell that is free for this robot_radius_m";
  const std::string moved =
      request.may_move ? fmt::format(" (more than snap_radius_m {} away)", snap_radius_m) : "";
  throw DataError("{} '{}' at {} {}; {}{}",
                  request.role,
                  request.text,
                  ToText(request.point_in_map),
                  WhyNotFree(grid, map, grid.CellOf(request.point_in_map)),
                  remedy,
                  nearest ? moved : "");
}

Candidates CandidatesFor(const OccupancyGrid& grid,
                         const CostMap& map,
                         const std::vector<std::int32_t>& labels,
                         const EndpointRequest& request,
                         double snap_radius_m) {
  const bool outside = !grid.Contains(grid.CellOf(request.point_in_map));
  const double radius_m = request.may_move && !outside ? snap_radius_m : 0;
  Candidates candidates = CellsWithin(grid, map, labels, request.point_in_map, radius_m);
  if (candidates.empty()) FailNotFree(grid, map, request, snap_radius_m);
  return candidates;
}

Endpoint MakeEndpoint(const OccupancyGrid& grid,
                      const EndpointRequest& request,
                      const Candidate& candidate) {
  const bool moved = candidate.distance_m > 0;
  return {request,
          moved ? grid.CenterInMap(candidate.cell) : request.point_in_map,
          candidate.cell,
          candidate.distance_m};
}

}  // namespace

EndpointRequest ParseEndpoint(const std::string& role,
                              const std::string& text,
                              const std::vector<QueryResult>& queries) {
  if (text.starts_with(kPicturePrefix) && text.size() > kPicturePrefix.size()) {
    const auto& picture = FindPicture(queries, text.substr(kPicturePrefix.size()));
    return {role, text, picture.map_from_camera.translation.head<2>(), true};
  }
  const auto comma = text.find(',');
  const auto x = ParseReal(text.substr(0, comma));
  const auto y = comma == std::string::npos ? std::nullopt : ParseReal(text.substr(comma + 1));
  if (!x || !y) {
    throw UsageError(
        "option {} is '{}': give \"x_m,y_m\" in the map frame or \"picture:NAME\"", role, text);
  }
  return {role, text, {*x, *y}, false};
}

std::pair<Endpoint, Endpoint> PlaceEndpoints(const OccupancyGrid& grid,
                                             const CostMap& map,
                                             const EndpointRequest& start,
                                             const EndpointRequest& goal,
                                             double snap_radius_m) {
  // Labels matter only where an end may move.
  const auto labels =
      start.may_move || goal.may_move ? LabelReachable(map) : std::vector<std::int32_t>();
  const Candidates starts = CandidatesFor(grid, map, labels, start, snap_radius_m);
  const Candidates goals = CandidatesFor(grid, map, labels, goal, snap_radius_m);
  Candidate best_start = *Nearest(starts);
  Candidate best_goal = *Nearest(goals);
  double best_m = std::numeric_limits<double>::infinity();
  for (const auto& [label, candidate] : starts) {
    const auto other = goals.find(label);
    if (other == goals.end() || candidate.distance_m + other->second.distance_m >= best_m) continue;
    best_m = candidate.distance_m + other->second.distance_m;
    best_start = candidate;
    best_goal = other->second;
  }
  return {MakeEndpoint(grid, start, best_start), MakeEndpoint(grid, goal, best_goal)};
}

}  // namespace nightmap
