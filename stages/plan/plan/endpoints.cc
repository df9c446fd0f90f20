// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/endpoints.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "pipeline/base/error.h"
#include "stages/plan/plan/block_field.h"
#include "stages/plan/plan/segment.h"
#include "stages/plan/plan/theta_star.h"

namespace nightmap {
namespace {

constexpr double kOwnCells_m = 0.1;    // around a thing its own cells may be occupied
constexpr double kRoomy_m = 0.15;      // an end that moves anyway may move by this for the margin
constexpr double kSamePlace_m = 2e-6;  // path.csv does not resolve smaller distances

struct Candidate {
  Eigen::Vector2i cell = Eigen::Vector2i::Zero();
  double distance_m = 0;  // from the requested point
  ThingSide side = ThingSide::kFront;
  double detour_m = 0;  // by which a place with more room may be farther

  auto Order() const { return std::pair(side, distance_m + detour_m); }
};

// The best free cell for each label of LabelReachable.
using Candidates = std::map<std::int32_t, Candidate>;

// A request with the cells that serve it.
struct Place {
  const EndpointRequest* request;
  Candidates candidates;
};

std::string ToText(const Eigen::Vector2d& point_m) {
  // Keeps messages free of hundreds of digits.
  const bool is_far = point_m.cwiseAbs().maxCoeff() > 1e12;
  return is_far ? fmt::format("{:g},{:g}", point_m.x(), point_m.y())
                : fmt::format("{:.3f},{:.3f}", point_m.x(), point_m.y());
}

bool HasFront(const EndpointRequest& request) { return request.box && request.box->has_front; }

// Whether the way from a point to a thing crosses an obstacle that is not the thing's own.
bool IsHidden(const OccupancyGrid& grid, const EndBox& box, const Eigen::Vector2d& point_in_map) {
  bool is_hidden = false;
  const auto visit = [&](const Eigen::Vector2i& cell, double) {
    if (box.Distance_m(grid.CenterInMap(cell)) <= kOwnCells_m) return false;
    is_hidden = grid.Contains(cell) && grid.At(cell) == kOccupiedCell;
    return !is_hidden;
  };
  VisitSegment(grid.ToCells(point_in_map), grid.ToCells(box.map_from_box.translation), visit);
  return is_hidden;
}

ThingSide SideOf(const OccupancyGrid& grid, const EndBox& box, const Eigen::Vector2d& point) {
  if (IsHidden(grid, box, point)) return ThingSide::kHidden;
  return box.IsInFront(point) ? ThingSide::kFront : ThingSide::kOther;
}

// Whether the robot can stand in a cell as the end. It stands in no thing, as under a table, even
// where the grid is free.
bool IsStandable(const OccupancyGrid& grid,
                 const CostMap& map,
                 const EndpointRequest& request,
                 const Eigen::Vector2i& cell) {
  if (!map.IsFree(cell)) return false;
  if (!HasFront(request)) return true;
  const double from_box_m = request.box->Distance_m(grid.CenterInMap(cell));
  return from_box_m > 0 && from_box_m >= map.robot_radius_m &&
         cell != grid.CellOf(request.point_in_map);
}

// A standable cell. The point's own cell counts at distance 0, wherever its centre is.
Candidate CandidateAt(const OccupancyGrid& grid,
                      const EndpointRequest& request,
                      const Eigen::Vector2i& cell) {
  const Eigen::Vector2d point = grid.CenterInMap(cell);
  const bool is_own = cell == grid.CellOf(request.point_in_map);
  const double distance_m = is_own ? 0 : (point - request.point_in_map).norm();
  return {
      cell, distance_m, HasFront(request) ? SideOf(grid, *request.box, point) : ThingSide::kFront};
}

// Free cells within a radius of a point or of a box.
Candidates CellsWithin(const OccupancyGrid& grid,
                       const CostMap& map,
                       const std::vector<std::int32_t>& labels,
                       const EndpointRequest& request,
                       double radius_m) {
  Candidates candidates;
  const Eigen::Vector2i own = grid.CellOf(request.point_in_map);
  const double half_box_m = request.box ? request.box->size_m.norm() / 2 : 0;
  const int reach = static_cast<int>(std::ceil((radius_m + half_box_m) / grid.resolution_m)) + 1;
  const Eigen::Vector2i first = (own.array() - reach).max(0);
  const Eigen::Vector2i last =
      (own.array() + reach).min(Eigen::Array2i(map.width - 1, map.height - 1));
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) {
      const Eigen::Vector2i cell(x, y);
      if (!IsStandable(grid, map, request, cell)) continue;
      const double distance_m = DistanceFrom_m(request, grid.CenterInMap(cell));
      if (cell != own && distance_m > radius_m) continue;
      Candidate candidate = CandidateAt(grid, request, cell);
      if (candidate.distance_m > 0 && !map.IsRoomy(cell)) candidate.detour_m = kRoomy_m;
      const auto [best, is_first] = candidates.try_emplace(labels[map.Index(cell)], candidate);
      if (candidate.Order() < best->second.Order()) best->second = candidate;
    }
  }
  return candidates;
}

Endpoint MakeEndpoint(const OccupancyGrid& grid,
                      const EndpointRequest& request,
                      const Candidate& candidate) {
  const bool moved = candidate.distance_m > 0;
  return {request,
          moved ? grid.CenterInMap(candidate.cell) : request.point_in_map,
          candidate.cell,
          candidate.distance_m,
          candidate.side};
}

// The request of an end, and its cell, that come first; all choices of an end have cells.
Endpoint Nearest(const OccupancyGrid& grid, const std::vector<Place>& places) {
  std::optional<Candidate> nearest;
  const EndpointRequest* request = nullptr;
  for (const Place& place : places) {
    for (const auto& [label, candidate] : place.candidates) {
      if (nearest && nearest->Order() <= candidate.Order()) continue;
      nearest = candidate;
      request = place.request;
    }
  }
  return MakeEndpoint(grid, *request, *nearest);
}

// The free cell of the whole grid that is nearest to a request.
std::optional<Eigen::Vector2i> NearestFree(const OccupancyGrid& grid,
                                           const CostMap& map,
                                           const EndpointRequest& request) {
  std::optional<Eigen::Vector2i> nearest;
  double least_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < map.Size(); ++i) {
    if (map.costs[i] == 0 || !IsStandable(grid, map, request, map.Cell(i))) continue;
    const double distance_m = DistanceFrom_m(request, grid.CenterInMap(map.Cell(i)));
    if (distance_m >= least_m) continue;
    least_m = distance_m;
    nearest = map.Cell(i);
  }
  return nearest;
}

std::string WhyNotFree(const OccupancyGrid& grid, const CostMap& map, const Eigen::Vector2i& cell) {
  if (!grid.Contains(cell)) {
    return "is outside of the map, which spans " + SpanText(grid);
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
  return request.box || grid.Contains(grid.CellOf(request.point_in_map));
}

[[noreturn]] void FailNotFree(const OccupancyGrid& grid,
                              const CostMap& map,
                              const EndpointRequest& request,
                              double snap_radius_m) {
  const Eigen::Vector2i own = grid.CellOf(request.point_in_map);
  const auto nearest = NearestFree(grid, map, request);
  std::string remedy = "the map has no cell that is free for this robot";
  if (nearest) {
    const Eigen::Vector2d point = grid.CenterInMap(*nearest);
    remedy = fmt::format("the nearest free cell is {:.2f} m {} at \"{}\"",
                         DistanceFrom_m(request, point),
                         request.box ? "from its rectangle" : "away",
                         ToText(point));
    if (MayMove(grid, request))
      remedy += fmt::format(", more than snap_radius_m {}", snap_radius_m);
  }
  const bool is_standable = map.IsFree(own);
  throw DataError("{} at {} {}; {}",
                  EndText(request),
                  ToText(request.point_in_map),
                  is_standable ? "has no free cell around it" : WhyNotFree(grid, map, own),
                  remedy);
}

// The choices of an end that the robot can stand at.
std::vector<Place> PlacesFor(const OccupancyGrid& grid,
                             const CostMap& map,
                             const std::vector<std::int32_t>& labels,
                             const EndChoices& choices,
                             double snap_radius_m) {
  std::vector<Place> places;
  for (const EndpointRequest& request : choices) {
    const double radius_m = MayMove(grid, request) ? snap_radius_m : 0;
    Candidates candidates = CellsWithin(grid, map, labels, request, radius_m);
    if (!candidates.empty()) places.push_back({&request, std::move(candidates)});
  }
  if (places.empty()) FailNotFree(grid, map, choices[0], snap_radius_m);
  return places;
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
  throw DataError("{} and {} are the same place{}: {}",
                  EndText(a.request),
                  EndText(b.request),
                  moved ? ", moved to where the robot can stand at " + ToText(b.point_in_map) : "",
                  moved ? "give ends farther apart, a smaller snap_radius_m or a smaller robot"
                        : "give another goal, or leave this one out");
}

// The ends as requested, if the robot can stand there and go from each to the next.
std::vector<Endpoint> PlaceAsAsked(const OccupancyGrid& grid,
                                   const CostMap& map,
                                   const std::vector<EndChoices>& choices) {
  std::vector<Endpoint> ends;
  for (const EndChoices& requests : choices) {
    const EndpointRequest& request = requests[0];
    const Eigen::Vector2i cell = grid.CellOf(request.point_in_map);
    if (requests.size() > 1 || HasFront(request) || !map.IsFree(cell)) return {};
    ends.push_back(MakeEndpoint(grid, request, {cell, 0}));
  }
  const BlockField field(map, ends[0].cell);
  const bool are_joined = std::all_of(
      ends.begin(), ends.end(), [&](const Endpoint& end) { return field.Reaches(end.cell); });
  return are_joined ? ends : std::vector<Endpoint>();
}

// Length of the way between two free cells that reach each other.
double WayInCells(const CostMap& map, const Eigen::Vector2i& from, const Eigen::Vector2i& to) {
  if (from == to) return 0;
  const SearchResult search = FindPath(map, from, to, Steps::kAnyAngle);
  double length = 0;
  for (std::size_t i = 1; i < search.cells.size(); ++i) {
    length += (search.cells[i] - search.cells[i - 1]).cast<double>().norm();
  }
  return length;
}

// The end, among ends in one part of the map, with the shortest way from a cell; the first on ties.
const Endpoint& NearestByWay(const CostMap& map,
                             const Eigen::Vector2i& from,
                             const std::vector<Endpoint>& ends) {
  std::vector<double> lengths;
  for (const Endpoint& end : ends) lengths.push_back(WayInCells(map, from, end.cell));
  return ends[static_cast<std::size_t>(std::ranges::min_element(lengths) - lengths.begin())];
}

// Moves each end into the part with a label; none when one has no place there.
std::vector<Endpoint> PlaceIn(const OccupancyGrid& grid,
                              const CostMap& map,
                              const std::vector<std::vector<Place>>& places,
                              std::int32_t label) {
  std::vector<Endpoint> ends;
  for (const std::vector<Place>& choices : places) {
    std::vector<Endpoint> there;
    for (const Place& place : choices) {
      const auto found = place.candidates.find(label);
      if (found == place.candidates.end()) continue;
      there.push_back(MakeEndpoint(grid, *place.request, found->second));
    }
    if (there.empty()) return {};
    const auto is_hidden = [](const Endpoint& end) { return end.side == ThingSide::kHidden; };
    if (!std::ranges::all_of(there, is_hidden)) std::erase_if(there, is_hidden);
    ends.push_back(there.size() == 1 ? there[0] : NearestByWay(map, ends.back().cell, there));
  }
  return ends;
}

// The measure that the choice of a part makes least. A place beside a box is where the end was
// asked to be, so no other end moves for a better one.
auto MovesOf(const std::vector<Endpoint>& ends) {
  double to_points_m = 0;
  double to_boxes_m = 0;
  int off_the_front = 0;
  for (const Endpoint& end : ends) {
    (end.request.box ? to_boxes_m : to_points_m) += end.moved_by_m;
    off_the_front += static_cast<int>(end.side);
  }
  return std::tuple(to_points_m, off_the_front, to_boxes_m);
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

// Moves all ends into one part of the map: roomy parts first, then the least moves; none when
// there is no such part. Avoids a part in which two ends become one place; if there is no
// other, that is the error.
std::vector<Endpoint> PlaceTogether(const OccupancyGrid& grid,
                                    const CostMap& map,
                                    const std::vector<std::vector<Place>>& places,
                                    const std::set<std::int32_t>& roomy) {
  std::vector<Endpoint> best, in_a_gap, too_near;
  for (const auto& [label, first] : places[0][0].candidates) {
    auto ends = PlaceIn(grid, map, places, label);
    if (ends.empty()) continue;
    const bool are_apart = FindSamePlace(ends) == ends.end();
    auto& least = !are_apart ? too_near : roomy.contains(label) ? best : in_a_gap;
    if (least.empty() || MovesOf(ends) < MovesOf(least)) least = std::move(ends);
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
                                     const std::vector<EndChoices>& choices,
                                     double snap_radius_m) {
  for (std::size_t i = 1; i < choices.size(); ++i) {
    if (choices[i - 1].size() > 1 || choices[i].size() > 1) continue;
    const Endpoint a{choices[i - 1][0], choices[i - 1][0].point_in_map};
    const Endpoint b{choices[i][0], choices[i][0].point_in_map};
    if (AreSamePlace(a, b)) FailSamePlace(a, b);
  }
  auto ends = PlaceAsAsked(grid, map, choices);
  if (!ends.empty()) return ends;
  const auto labels = LabelReachable(map);
  std::vector<std::vector<Place>> places;
  for (const EndChoices& requests : choices) {
    places.push_back(PlacesFor(grid, map, labels, requests, snap_radius_m));
  }
  ends = PlaceTogether(grid, map, places, RoomyParts(map, labels));
  if (!ends.empty()) return ends;
  for (const std::vector<Place>& of_end : places) ends.push_back(Nearest(grid, of_end));
  return ends;
}

double DistanceFrom_m(const EndpointRequest& request, const Eigen::Vector2d& point_in_map) {
  return request.box ? request.box->Distance_m(point_in_map)
                     : (point_in_map - request.point_in_map).norm();
}

}  // namespace nightmap
