// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/endpoints.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

struct Candidate {
  Eigen::Vector2i cell = Eigen::Vector2i::Zero();
  double distance_m = std::numeric_limits<double>::infinity();
};

// Nearest free cell for each label of LabelReachable.
using Candidates = std::map<std::int32_t, Candidate>;

std::pair<int, int> ToPair(const Eigen::Vector2i& cell) { return {cell.x(), cell.y()}; }

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

// The parts of the map that reach each other, by LabelReachable.
struct Parts {
  std::vector<std::int32_t> labels;    // empty: nothing may move, all free cells count as one part
  std::vector<std::size_t> num_cells;  // by label
  double min_cells = 0;                // of a part that is larger than the robot

  bool IsRoomy(std::int32_t label) const {
    return labels.empty() ||
           static_cast<double>(num_cells[static_cast<std::size_t>(label)]) >= min_cells;
  }
};

Parts FindParts(const OccupancyGrid& grid, const CostMap& map) {
  Parts parts;
  parts.labels = LabelReachable(map);
  parts.num_cells.resize(1 + static_cast<std::size_t>(std::ranges::max(parts.labels)));
  for (const std::int32_t label : parts.labels) ++parts.num_cells[static_cast<std::size_t>(label)];
  const double robot_cells = map.robot_radius_m / grid.resolution_m;
  parts.min_cells = std::max(2.0, std::numbers::pi * robot_cells * robot_cells);
  return parts;
}

// In a roomy part if there is one, else the nearest of all.
Candidate Nearest(const Parts& parts, const Candidates& candidates) {
  const auto order = [&](const auto& item) {
    return std::pair(!parts.IsRoomy(item.first), item.second.distance_m);
  };
  return std::ranges::min_element(candidates, {}, order)->second;
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

// Sum of the moves into a part of the map; infinite where an end has no candidate in it.
double SumOfMoves_m(const std::vector<Candidates>& candidates, std::int32_t label) {
  double sum_m = 0;
  for (const Candidates& of_end : candidates) {
    const auto found = of_end.find(label);
    if (found == of_end.end()) return std::numeric_limits<double>::infinity();
    sum_m += found->second.distance_m;
  }
  return sum_m;
}

// The part that PlaceEndpoints chooses; 0 where no part has a candidate of every end. A part in
// which two ends become one place comes last: there is no way to plan in it.
std::int32_t CommonLabel(const Parts& parts, const std::vector<Candidates>& candidates) {
  const auto joins_ends = [&](std::int32_t label) {
    return std::ranges::adjacent_find(candidates, {}, [&](const Candidates& of_end) {
             return ToPair(of_end.at(label).cell);
           }) != candidates.end();
  };
  std::int32_t best_label = 0;
  std::tuple<bool, bool, double> best;
  for (const auto& [label, first] : candidates[0]) {
    const double sum_m = SumOfMoves_m(candidates, label);
    if (std::isinf(sum_m)) continue;
    const std::tuple order(joins_ends(label), !parts.IsRoomy(label), sum_m);
    if (best_label != 0 && order >= best) continue;
    best = order;
    best_label = label;
  }
  return best_label;
}

void CheckApart(const std::vector<Endpoint>& ends, double snap_radius_m) {
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const Endpoint &a = ends[i - 1], &b = ends[i];
    if (a.point_in_map != b.point_in_map) continue;
    const bool moved = a.moved_by_m > 0 || b.moved_by_m > 0;
    throw DataError("{} '{}' and {} '{}' are one place, {}: {}",
                    a.request.role,
                    a.request.text,
                    b.request.role,
                    b.request.text,
                    ToText(a.point_in_map),
                    moved ? fmt::format("the nearest that is free for the robot; give places that "
                                        "are free, or lower snap_radius_m {}",
                                        snap_radius_m)
                          : "there is no way to plan; give two places");
  }
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
  // Parts matter only where an end may move.
  const bool any_may_move = std::any_of(requests.begin(), requests.end(), [&](const auto& request) {
    return MayMove(grid, map, request);
  });
  const Parts parts = any_may_move ? FindParts(grid, map) : Parts();
  std::vector<Candidates> candidates;
  for (const EndpointRequest& request : requests) {
    candidates.push_back(CandidatesFor(grid, map, parts.labels, request, snap_radius_m));
  }
  const std::int32_t label = CommonLabel(parts, candidates);
  std::vector<Endpoint> endpoints;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto common = candidates[i].find(label);
    endpoints.push_back(MakeEndpoint(
        grid,
        requests[i],
        common != candidates[i].end() ? common->second : Nearest(parts, candidates[i])));
  }
  CheckApart(endpoints, snap_radius_m);
  return endpoints;
}

}  // namespace nightmap
