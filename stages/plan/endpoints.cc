// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/endpoints.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

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
    return fmt::format("is outside of the map, which spans {} to {}",
                       ToText(grid.origin_in_map),
                       ToText(grid.FromCells(Eigen::Vector2d(grid.width, grid.height))));
  }
  if (grid.At(cell) == kOccupiedCell) return "is inside an obstacle";
  if (grid.At(cell) == kUnknownCell && map.distances.Squared(cell, 1) == 0) {
    return "is in unknown space";
  }
  return fmt::format(
      "is in a cell {:.3f} m from an obstacle or unknown space, nearer than the robot's radius {}",
      map.Clearance_m(cell),
      map.robot_radius_m);
}

[[noreturn]] void FailNotFree(const OccupancyGrid& grid,
                              const CostMap& map,
                              const EndpointRequest& request,
                              double snap_radius_m) {
  const Eigen::Vector2i own = grid.CellOf(request.point_in_map);
  const auto nearest = NearestFree(grid, map, request.point_in_map);
  const std::string remedy = nearest
                                 ? fmt::format("the nearest free cell is {:.2f} m away at \"{}\"",
                                               nearest->distance_m,
                                               ToText(grid.CenterInMap(nearest->cell)))
                                 : "the map has no cell that is free for this robot";
  const std::string limit = nearest && grid.Contains(own)
                                ? fmt::format(", more than snap_radius_m {}", snap_radius_m)
                                : "";
  throw DataError("{} '{}' at {} {}; {}{}",
                  request.role,
                  request.text,
                  ToText(request.point_in_map),
                  WhyNotFree(grid, map, own),
                  remedy,
                  limit);
}

bool MayMove(const OccupancyGrid& grid, const CostMap& map, const EndpointRequest& request) {
  const Eigen::Vector2i own = grid.CellOf(request.point_in_map);
  return grid.Contains(own) && (request.is_picture || !map.IsFree(own));
}

Candidates CandidatesFor(const OccupancyGrid& grid,
                         const CostMap& map,
                         const std::vector<std::int32_t>& labels,
                         const EndpointRequest& request,
                         double snap_radius_m) {
  const double radius_m = MayMove(grid, map, request) ? snap_radius_m : 0;
  Candidates candidates = CellsWithin(grid, map, labels, request.point_in_map, radius_m);
  if (candidates.empty()) FailNotFree(grid, map, request, snap_radius_m);
  return candidates;
}

// The label that all ends have a candidate of, with the least sum of moves; 0 where there is none.
std::int32_t CommonLabel(const std::vector<Candidates>& candidates) {
  std::int32_t best_label = 0;
  double best_m = std::numeric_limits<double>::infinity();
  for (const auto& [label, first] : candidates[0]) {
    double sum_m = 0;
    for (const Candidates& others : candidates) {
      const auto other = others.find(label);
      sum_m += other != others.end() ? other->second.distance_m
                                     : std::numeric_limits<double>::infinity();
    }
    if (sum_m >= best_m) continue;
    best_m = sum_m;
    best_label = label;
  }
  return best_label;
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

std::vector<Endpoint> PlaceEndpoints(const OccupancyGrid& grid,
                                     const CostMap& map,
                                     const std::vector<EndpointRequest>& requests,
                                     double snap_radius_m) {
  // Labels matter only where an end may move.
  const bool any_may_move = std::any_of(requests.begin(), requests.end(), [&](const auto& request) {
    return MayMove(grid, map, request);
  });
  const auto labels = any_may_move ? LabelReachable(map) : std::vector<std::int32_t>();
  std::vector<Candidates> candidates;
  for (const EndpointRequest& request : requests) {
    candidates.push_back(CandidatesFor(grid, map, labels, request, snap_radius_m));
  }
  const std::int32_t label = CommonLabel(candidates);
  std::vector<Endpoint> endpoints;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto common = candidates[i].find(label);
    endpoints.push_back(
        MakeEndpoint(grid,
                     requests[i],
                     common != candidates[i].end() ? common->second : *Nearest(candidates[i])));
  }
  return endpoints;
}

}  // namespace nightmap
