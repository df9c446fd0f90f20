// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "pipeline/base/error.h"
#include "stages/plan/search.h"
#include "stages/plan/shorten.h"

namespace nightmap {
namespace {

constexpr int kNumTightenPasses = 4;  // even: the route ends up in its own direction

std::string PointText(const Eigen::Vector3d& position) {
  return fmt::format("trajectory at {:.3f},{:.3f}", position.x(), position.y());
}

// The default ends: first and last located query, else of the trajectory.
EndpointRequest DefaultEndpoint(const std::string& role, const PlanInputs& inputs) {
  const bool first = role == "start";
  std::vector<const QueryResult*> located;
  for (const auto& query : inputs.queries) {
    if (query.IsLocated()) located.push_back(&query);
  }
  if (!located.empty()) {
    const QueryResult& picture = first ? *located.front() : *located.back();
    return {
        role, "picture:" + picture.color_path, picture.map_from_camera.translation.head<2>(), true};
  }
  if (!inputs.trajectory.empty()) {
    const StampedPose& pose = first ? inputs.trajectory.front() : inputs.trajectory.back();
    const Eigen::Vector3d& position = pose.pose.translation;
    return {role, PointText(position), position.head<2>(), true};
  }
  throw UsageError(
      "option {} is empty and there is no located query: set plan.{} = \"x_m,y_m\"", role, role);
}

EndpointRequest Request(const std::string& role,
                        const std::string& text,
                        const PlanInputs& inputs) {
  return text.empty() ? DefaultEndpoint(role, inputs) : ParseEndpoint(role, text, inputs.queries);
}

[[noreturn]] void FailUnreachable(const OccupancyGrid& grid,
                                  const SearchResult& search,
                                  const Endpoint& start,
                                  const Endpoint& goal) {
  const Eigen::Vector2d nearest = grid.CenterInMap(search.nearest_reached);
  const double cell_m2 = grid.resolution_m * grid.resolution_m;
  throw DataError(
      "no path from start '{}' to goal '{}': the start reaches {:.2f} m2, at its nearest "
      "{:.3f},{:.3f}, {:.2f} m from the goal; try a smaller robot_radius_m or unknown_is_obstacle "
      "= "
      "false",
      start.request.text,
      goal.request.text,
      cell_m2 * static_cast<double>(search.num_expanded),
      nearest.x(),
      nearest.y(),
      (nearest - goal.point_in_map).norm());
}

// From the exact start over the centres of the cells to the exact goal, in units of cells.
std::vector<Eigen::Vector2d> Route(const OccupancyGrid& grid,
                                   const std::vector<Eigen::Vector2i>& cells,
                                   const PlanResult& result) {
  std::vector<Eigen::Vector2d> route = {grid.ToCells(result.start.point_in_map)};
  const auto append = [&](const Eigen::Vector2d& point) {
    if ((point - route.back()).norm() > 1e-9) route.push_back(point);
  };
  for (const Eigen::Vector2i& cell : cells) {
    append(cell.cast<double>() + Eigen::Vector2d(0.5, 0.5));
  }
  append(grid.ToCells(result.goal.point_in_map));
  return route;
}

// Greedy shortcuts depend on the end they start from, so both ends take turns. The result is
// sampled.
std::vector<Eigen::Vector2d> Tighten(const CostMap& map, std::vector<Eigen::Vector2d> route) {
  for (int pass = 0; pass < kNumTightenPasses; ++pass) {
    route = Resample(Shorten(map, route));
    std::reverse(route.begin(), route.end());
  }
  return route;
}

std::vector<PathPoint> MakePath(const OccupancyGrid& grid,
                                const std::vector<Eigen::Vector2d>& points) {
  std::vector<PathPoint> path(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    path[i].point_in_map = grid.origin_in_map + grid.resolution_m * points[i];
    if (i == 0) continue;
    const Eigen::Vector2d step = path[i].point_in_map - path[i - 1].point_in_map;
    path[i - 1].heading_rad = std::atan2(step.y(), step.x());
    path[i].heading_rad = path[i - 1].heading_rad;
    path[i].distance_m = path[i - 1].distance_m + step.norm();
  }
  return path;
}

// Smallest clearance along the path; throws when the robot would not fit somewhere.
double CheckClearance_m(const CostMap& map, const std::vector<Eigen::Vector2d>& points) {
  double clearance_m = map.Clearance_m(points[0].array().floor().cast<int>());
  for (std::size_t i = 0; i < points.size(); ++i) {
    VisitSegment(points[i > 0 ? i - 1 : 0], points[i], [&](const Eigen::Vector2i& cell, double) {
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

}  // namespace

void PlanOptions::Register(OptionList& list) {
  list.Add(
      "start", &start, "\"x_m,y_m\" in the map, \"picture:NAME\", or \"\": first located query");
  list.Add("goal", &goal, "\"x_m,y_m\" in the map, \"picture:NAME\", or \"\": last located query");
  list.Add("robot_radius_m", &robot.robot_radius_m, Range(0.0, 5.0), "radius of the round robot");
  list.Add(
      "unknown_is_obstacle", &robot.unknown_is_obstacle, "do not drive where nothing was seen");
  list.Add("clearance_m",
           &robot.clearance_m,
           Range(0.0, 10.0),
           "obstacles farther away than this do not make a path dearer");
  list.Add("clearance_weight",
           &robot.clearance_weight,
           Range(0.0, 50.0),
           "extra cost of a metre at robot_radius_m from an obstacle; 0: shortest path");
  list.Add("snap_radius_m",
           &snap_radius_m,
           Range(0.0, 10.0),
           "how far a picture's place may be moved to a cell the robot can stand on");
  list.Add("shorten", &shorten, "replace the grid's zigzag by straight lines where they are free");
}

PlanResult RunPlan(const PlanOptions& options,
                   const PlanInputs& inputs,
                   Progress& progress,
                   int num_threads) {
  const OccupancyGrid& grid = inputs.grid;
  progress.Start(3);
  const EndpointRequest start = Request("start", options.start, inputs);
  const EndpointRequest goal = Request("goal", options.goal, inputs);
  const CostMap map = MakeCostMap(grid, options.robot, num_threads);
  progress.Advance();

  PlanResult result;
  std::tie(result.start, result.goal) =
      PlaceEndpoints(grid, map, start, goal, options.snap_radius_m);
  const SearchResult search = FindPath(map, result.start.cell, result.goal.cell);
  if (!search.found) FailUnreachable(grid, search, result.start, result.goal);
  progress.Advance();

  std::vector<Eigen::Vector2d> route = Route(grid, search.cells, result);
  route = options.shorten ? Tighten(map, route) : Resample(route);
  result.min_clearance_m = CheckClearance_m(map, route);
  result.path = MakePath(grid, route);
  result.length_m = result.path.back().distance_m;
  result.num_cells = search.cells.size();
  result.num_expanded = search.num_expanded;
  result.search_cost_m = grid.resolution_m * SearchCost::InCells(search.cost);
  progress.Finish();
  return result;
}

}  // namespace nightmap
