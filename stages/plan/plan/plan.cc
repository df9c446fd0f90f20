// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/plan/unknown_holes.h"
#include "stages/plan/plan/no_path.h"
#include "stages/plan/plan/pull_tight.h"
#include "stages/plan/plan/segment.h"
#include "stages/plan/plan/theta_star.h"

namespace nightmap {
namespace {

// From the exact start through the cells' centres to the exact goal, in cells.
std::vector<Eigen::Vector2d> Route(const OccupancyGrid& grid,
                                   const std::vector<Eigen::Vector2i>& cells,
                                   const Endpoint& start,
                                   const Endpoint& goal) {
  std::vector<Eigen::Vector2d> route = {grid.ToCells(start.point_in_map)};
  const auto append = [&](const Eigen::Vector2d& point) {
    if ((point - route.back()).norm() > 1e-9) route.push_back(point);
  };
  for (const Eigen::Vector2i& cell : cells) {
    append(cell.cast<double>() + Eigen::Vector2d(0.5, 0.5));
  }
  append(grid.ToCells(goal.point_in_map));
  return route;
}

// Smallest clearance of the cells along a route; throws when one is not free.
double MinClearance_m(const CostMap& map, const std::vector<Eigen::Vector2d>& route) {
  double clearance_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < route.size(); ++i) {
    VisitSegment(route[i > 0 ? i - 1 : 0], route[i], [&](const Eigen::Vector2i& cell, double) {
      if (!map.IsFree(cell)) {
        throw DataError("the planned path touches cell {},{}, which is not free: report this bug",
                        cell.x(),
                        cell.y());
      }
      clearance_m = std::min(clearance_m, map.Clearance_m(cell));
      return true;
    });
  }
  return clearance_m;
}

// Appends a leg's points, without the first one, which is already there, except on the first leg.
void AppendLeg(const OccupancyGrid& grid,
               const CostMap& map,
               const std::vector<Eigen::Vector2d>& route,
               PlanResult& result) {
  PlanLeg& leg = result.legs.back();
  auto& path = result.path;
  const int leg_idx = static_cast<int>(result.legs.size()) - 1;
  leg.first_point = path.empty() ? 0 : path.size() - 1;
  for (std::size_t i = path.empty() ? 0 : 1; i < route.size(); ++i) {
    PathPoint point;
    point.point_in_map = grid.FromCells(route[i]);
    point.leg_idx = leg_idx;
    point.clearance_m = map.Clearance_m(route[i].array().floor().cast<int>());
    if (!path.empty()) {
      const Eigen::Vector2d step = point.point_in_map - path.back().point_in_map;
      path.back().heading_rad = std::atan2(step.y(), step.x());
      point.heading_rad = path.back().heading_rad;
      point.distance_m = path.back().distance_m + step.norm();
    }
    path.push_back(point);
  }
  leg.last_point = path.size() - 1;
  leg.length_m = path.back().distance_m - path[leg.first_point].distance_m;
  leg.min_clearance_m = MinClearance_m(map, route);
}

// Asks at every point as drive will.
void CheckFootprint(const OccupancyGrid& grid, const CostMap& map, const PlanResult& result) {
  for (const PathPoint& point : result.path) {
    if (map.distances.Fits(grid.ToCells(point.point_in_map), map.robot_radius_m)) continue;
    throw DataError("on the planned path the robot touches an obstacle at {},{}: report this bug",
                    point.point_in_map.x(),
                    point.point_in_map.y());
  }
}

void PlanLegs(const PlanOptions& options,
              const OccupancyGrid& grid,
              const CostMap& map,
              PlanResult& result) {
  const Steps steps = options.planner == "astar" ? Steps::kCellToCell : Steps::kAnyAngle;
  for (std::size_t i = 0; i + 1 < result.ends.size(); ++i) {
    const Endpoint& start = result.ends[i];
    const Endpoint& goal = result.ends[i + 1];
    const SearchResult search = FindPath(map, start.cell, goal.cell, steps);
    if (!search.found) FailUnreachable(grid, map, options.cost, start, goal);
    const auto route = Route(grid, search.cells, start, goal);
    result.legs.emplace_back();
    result.legs.back().search_cost_m = grid.resolution_m * search.cost_cells;
    result.legs.back().num_vertices = search.cells.size();
    result.legs.back().num_expanded = search.num_expanded;
    AppendLeg(grid, map, options.shorten ? Tighten(map, route) : Resample(route), result);
  }
}

// The robot turns in place to face the thing that it came for.
void FaceThing(PlanResult& result) {
  const auto& box = result.ends.back().request.box;
  PathPoint& last = result.path.back();
  if (box && box->has_front) last.heading_rad = box->HeadingFrom_rad(last.point_in_map);
}

std::vector<EndChoices> Requests(const PlanOptions& options, const PlanInputs& inputs) {
  return MakeRequests(options.start,
                      options.goal,
                      {inputs.queries, inputs.trajectory, inputs.objects, inputs.things});
}

}  // namespace

std::vector<EndChoices> RequestsOnFloor(const PlanOptions& options, const PlanInputs& inputs) {
  return KeepOnFloor(Requests(options, inputs), inputs.floors, inputs.floor_idx);
}

std::size_t PlanFloor(const PlanOptions& options, const PlanInputs& inputs) {
  return ChooseFloor(Requests(options, inputs), inputs.floors, options.floor);
}

PlanResult RunPlan(const PlanOptions& options,
                   const PlanInputs& inputs,
                   Progress& progress,
                   int num_threads) {
  progress.Start(3);
  const double radius_m = CircumscribedRadius_m(options.footprint);
  const auto requests = RequestsOnFloor(options, inputs);
  PlanResult result;
  result.floor = inputs.floors[inputs.floor_idx];
  const auto holes = FindUnknownHoles(inputs.grid, options.cost.max_hole_m);
  result.num_hole_cells = holes.size();
  const OccupancyGrid grid = WithCellsFree(inputs.grid, holes);
  const CostMap map = MakeCostMap(grid, options.cost, radius_m, num_threads);
  progress.Advance();
  result.ends = PlaceEndpoints(grid, map, requests, options.snap_radius_m);
  PlanLegs(options, grid, map, result);
  FaceThing(result);
  progress.Advance();
  CheckFootprint(grid, map, result);
  result.narrow_places = FindNarrowPlaces(result.path, radius_m, options.cost.margin_m);
  progress.Finish();
  return result;
}

}  // namespace nightmap
