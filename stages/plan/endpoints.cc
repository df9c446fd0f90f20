// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/endpoints.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "pipeline/base/error.h"
#include "stages/plan/block_field.h"

namespace nightmap {
namespace {

constexpr double kSamePlace_m = 2e-6;  // path.csv does not resolve smaller distances

struct Candidate {
  Eigen::Vector2i cell = Eigen::Vector2i::Zero();
  double distance_m = std::numeric_limits<double>::infinity();
};

// Nearest free cell for each label of LabelReachable.
using Candidates = std::map<std::int32_t, Candidate>;

std::string ToText(const Eigen::Vector2d& point_m) {
  // Keeps messages free of hundreds of digits.
  const bool is_far = point_m.cwiseAbs().maxCoeff() > 1e12;
  return is_far ? fmt::format("{:g},{:g}", point_m.x(), point_m.y())
                : fmt::format("{:.3f},{:.3f}", point_m.x(), point_m.y());
}

// Free cells within a radius. The point's own cell counts at distance 0, wherever its centre is.
Candidates CellsWithin(const OccupancyGrid& grid,
                       const CostMap& map,
                       const std::vector<std::int32_t>& labels,
                       const Eigen::Vector2d& point_in_map,
                       double radius_m) {
  Candidates candidates;
  const Eigen::Vector2i own = grid.CellOf(point_in_map);
  const int reach = static_cast<int>(std::ceil(radius_m / grid.resolution_m)) + 1;
  const Eigen::Vector2i first = (own.array() - reach).max(0);
  const Eigen::Vector2i last =
      (own.array() + reach).min(Eigen::Array2i(map.width - 1, map.height - 1));
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) {
      const Eigen::Vector2i cell(x, y);
      if (!map.IsFree(cell)) continue;
      const double distance_m = cell == own ? 0 : (grid.CenterInMap(cell) - point_in_map).norm();
      Candidate& best = candidates[labels[map.Index(cell)]];
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

// Least and greatest x and y of the grid's corners; a grid with a yaw is turned within them.
std::pair<Eigen::Vector2d, Eigen::Vector2d> Bounds(const OccupancyGrid& grid) {
  Eigen::AlignedBox2d box;
  for (const int x : {0, grid.width}) {
    for (const int y : {0, grid.height}) box.extend(grid.FromCells(Eigen::Vector2d(x, y)));
  }
  return {box.min(), box.max()};
}

std::string WhyNotFree(const OccupancyGrid& grid, const CostMap& map, const Eigen::Vector2i& cell) {
  if (!grid.Contains(cell)) {
    const auto [least, most] = Bounds(grid);
    return fmt::format("is outside of the map, which spans {} to {}", ToText(least), ToText(most));
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

// An object in the outer wall may have its centre outside of the map.
bool MayMove(const OccupancyGrid& grid, const EndpointRequest& request) {
  return request.half_extent_m > 0 || grid.Contains(grid.CellOf(request.point_in_map));
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
  const std::string beside =
      request.half_extent_m > 0
          ? fmt::format(" and half the diagonal of the object, {:.2f} m", request.half_extent_m)
          : "";
  const std::string limit =
      nearest && MayMove(grid, request)
          ? fmt::format(", more than snap_radius_m {}{}", snap_radius_m, beside)
          : "";
  throw DataError("{} '{}' at {} {}; {}{}",
                  request.role,
                  request.text,
                  ToText(request.point_in_map),
                  WhyNotFree(grid, map, own),
                  remedy,
                  limit);
}

Candidates CandidatesFor(const OccupancyGrid& grid,
                         const CostMap& map,
                         const std::vector<std::int32_t>& labels,
                         const EndpointRequest& request,
                         double snap_radius_m) {
  const double radius_m = MayMove(grid, request) ? snap_radius_m + request.half_extent_m : 0;
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

// Whether two successive ends coincide, so that their leg would have no length.
bool AreSamePlace(const Endpoint& a, const Endpoint& b) {
  const bool moved = a.moved_by_m > 0 || b.moved_by_m > 0;
  return (moved && a.cell == b.cell) || (a.point_in_map - b.point_in_map).norm() < kSamePlace_m;
}

// The first such pair, or the list's end.
auto FindSamePlace(const std::vector<Endpoint>& ends) {
  return std::adjacent_find(ends.begin(), ends.end(), AreSamePlace);
}

[[noreturn]] void FailSamePlace(const Endpoint& a, const Endpoint& b) {
  const bool moved = a.moved_by_m > 0 || b.moved_by_m > 0;
  throw DataError("{} '{}' and {} '{}' are the same place{}: {}",
                  a.request.role,
                  a.request.text,
                  b.request.role,
                  b.request.text,
                  moved ? ", moved to where the robot can stand at " + ToText(b.point_in_map) : "",
                  moved ? "give ends farther apart, a smaller snap_radius_m or a smaller robot"
                        : "give another goal, or leave this one out");
}

// The ends as requested, if the robot can stand there and go from each to the next.
std::vector<Endpoint> PlaceAsAsked(const OccupancyGrid& grid,
                                   const CostMap& map,
                                   const std::vector<EndpointRequest>& requests) {
  std::vector<Endpoint> ends;
  for (const EndpointRequest& request : requests) {
    const Eigen::Vector2i cell = grid.CellOf(request.point_in_map);
    if (!map.IsFree(cell)) return {};
    ends.push_back(MakeEndpoint(grid, request, {cell, 0}));
  }
  const BlockField field(map, ends[0].cell);
  const bool are_joined = std::all_of(
      ends.begin(), ends.end(), [&](const Endpoint& end) { return field.Reaches(end.cell); });
  return are_joined ? ends : std::vector<Endpoint>();
}

// Moves each end into the part with a label; none when one has no place there.
std::vector<Endpoint> PlaceIn(const OccupancyGrid& grid,
                              const std::vector<EndpointRequest>& requests,
                              const std::vector<Candidates>& candidates,
                              std::int32_t label) {
  std::vector<Endpoint> ends;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    const auto found = candidates[i].find(label);
    if (found == candidates[i].end()) return {};
    ends.push_back(MakeEndpoint(grid, requests[i], found->second));
  }
  return ends;
}

double SumOfMoves_m(const std::vector<Endpoint>& ends) {
  double sum_m = 0;
  for (const Endpoint& end : ends) sum_m += end.moved_by_m;
  return sum_m;
}

// Labels of the parts in which the robot's centre can move over more than the robot's own area. A
// smaller part is a gap between objects, not a place to drive.
std::set<std::int32_t> RoomyParts(const CostMap& map, const std::vector<std::int32_t>& labels) {
  std::map<std::int32_t, std::size_t> num_cells;
  for (const std::int32_t label : labels) ++num_cells[label];
  const double robot_cells = map.robot_radius_m / map.resolution_m;
  const double min_cells = std::max(2.0, std::numbers::pi * robot_cells * robot_cells);
  std::set<std::int32_t> roomy;
  for (const auto& [label, count] : num_cells) {
    if (label != 0 && static_cast<double>(count) >= min_cells) roomy.insert(label);
  }
  return roomy;
}

// Moves all ends into one part of the map: roomy parts first, then the least sum of moves; none
// when there is no such part. Avoids a part in which two ends become one place; if there is no
// other, that is the error.
std::vector<Endpoint> PlaceTogether(const OccupancyGrid& grid,
                                    const std::vector<EndpointRequest>& requests,
                                    const std::vector<Candidates>& candidates,
                                    const std::set<std::int32_t>& roomy) {
  std::vector<Endpoint> best, in_a_gap, too_near;
  for (const auto& [label, first] : candidates[0]) {
    auto ends = PlaceIn(grid, requests, candidates, label);
    if (ends.empty()) continue;
    const bool are_apart = FindSamePlace(ends) == ends.end();
    auto& least = !are_apart ? too_near : roomy.contains(label) ? best : in_a_gap;
    if (least.empty() || SumOfMoves_m(ends) < SumOfMoves_m(least)) least = std::move(ends);
  }
  if (!best.empty()) return best;
  if (in_a_gap.empty() && !too_near.empty()) {
    const auto same = FindSamePlace(too_near);
    FailSamePlace(same[0], same[1]);
  }
  return in_a_gap;
}

}  // namespace

std::vector<Endpoint> PlaceEndpoints(const OccupancyGrid& grid,
                                     const CostMap& map,
                                     const std::vector<EndpointRequest>& requests,
                                     double snap_radius_m) {
  for (std::size_t i = 1; i < requests.size(); ++i) {
    const Endpoint a{requests[i - 1], requests[i - 1].point_in_map};
    const Endpoint b{requests[i], requests[i].point_in_map};
    if (AreSamePlace(a, b)) FailSamePlace(a, b);
  }
  auto ends = PlaceAsAsked(grid, map, requests);
  if (!ends.empty()) return ends;
  const auto labels = LabelReachable(map);
  std::vector<Candidates> candidates;
  for (const EndpointRequest& request : requests) {
    candidates.push_back(CandidatesFor(grid, map, labels, request, snap_radius_m));
  }
  ends = PlaceTogether(grid, requests, candidates, RoomyParts(map, labels));
  if (!ends.empty()) return ends;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    ends.push_back(MakeEndpoint(grid, requests[i], *Nearest(candidates[i])));
  }
  return ends;
}

}  // namespace nightmap
