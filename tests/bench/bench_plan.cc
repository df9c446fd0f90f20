// SPDX-License-Identifier: Apache-2.0
// Times path planning on synthetic office floors of 100 m x 100 m at 5 cm, aligned with the grid
// and rotated against it, on random routes of about 90 m, and prints a table:
//   ninja -C build bench_plan && build/bench_plan
// Times are the best of several repeats, as mean (and worst) over the routes. "search" is CPU time
// on one thread of the search on the cost map; for the any-angle planner it includes pulling tight,
// which its path always has. Wall time on two threads is given for the cost map with its distance
// transform and for everything from the grid to the path ("all", RunPlan: cost map, search, pulling
// tight, checks). References are Dijkstra's algorithm with a heap of the standard library and, for
// paths in any direction, the cheapest path of lines in 80 directions, pulled tight. "shortest" has
// clearance_weight = margin_weight = 0, so that the cost of a path is its length. "A* as published"
// has no cost near obstacles: it finds the shortest path from cell to cell, whatever the options of
// the floor.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <vector>

#include "stages/plan/plan/plan.h"
#include "stages/plan/plan/pull_tight.h"
#include "stages/plan/plan/theta_star.h"
#include "tests/stages/plan/plan/office_floor.h"
#include "tests/stages/plan/plan/reference_path.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap {
namespace {

constexpr int kNumRoutes = 10;
constexpr int kNumRepeats = 5;
constexpr double kRadius_m = 0.25;

constexpr int kNumThreads = 2;  // of what is timed by the wall clock

double Time_ms(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

double BestTime_ms(const std::function<void()>& work,
                   int num_repeats = kNumRepeats,
                   clockid_t clock = CLOCK_PROCESS_CPUTIME_ID) {
  double best_ms = 1e9;
  for (int i = 0; i < num_repeats; ++i) {
    const double start_ms = Time_ms(clock);
    work();
    best_ms = std::min(best_ms, Time_ms(clock) - start_ms);
  }
  return best_ms;
}

double BestWallTime_ms(const std::function<void()>& work) {
  return BestTime_ms(work, kNumRepeats, CLOCK_MONOTONIC);
}

double All_ms(const OccupancyGrid& grid,
              const CostOptions& cost,
              const Eigen::Vector2i& start,
              const Eigen::Vector2i& goal,
              const std::string& planner,
              bool shorten) {
  const PlanInputs inputs{grid, {}, {}};
  PlanOptions options;
  options.cost = cost;
  options.footprint.robot_radius_m = kRadius_m;
  const auto text = [&](const Eigen::Vector2i& cell) {
    const Eigen::Vector2d point = grid.CenterInMap(cell);
    return fmt::format("{:.3f},{:.3f}", point.x(), point.y());
  };
  options.start = text(start);
  options.goal = text(goal);
  options.planner = planner;
  options.shorten = shorten;
  return BestWallTime_ms([&] {
    Progress progress("plan", false);
    RunPlan(options, inputs, progress, kNumThreads);
  });
}

// Means over the routes, and the worst.
struct Column {
  std::vector<double> values;
  double Mean() const {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  }
  double Max() const { return *std::max_element(values.begin(), values.end()); }
  double Min() const { return *std::min_element(values.begin(), values.end()); }
};

struct Columns {
  Column dijkstra_ms, astar_ms, astar_all_ms, astar_above_percent;
  Column any_angle_ms, any_angle_all_ms, any_angle_above_percent;
  Column shorter_percent, cheaper_percent, optimum_shorter_percent, shorter_than_published_percent;

  std::size_t NumRoutes() const { return dijkstra_ms.values.size(); }
};

void BenchRoute(const OccupancyGrid& grid,
                const CostOptions& cost,
                const CostMap& map,
                const CostMap& map_of_lengths,
                const Eigen::Vector2i& start,
                const Eigen::Vector2i& goal,
                Columns& columns) {
  const auto add = [](Column& column, double value) { column.values.push_back(value); };
  std::vector<std::int64_t> to_goal;
  add(columns.dijkstra_ms, BestTime_ms([&] { to_goal = DijkstraCosts(map, goal); }, 1));
  SearchResult astar;
  add(columns.astar_ms,
      BestTime_ms([&] { astar = FindPath(map, start, goal, Steps::kCellToCell); }));
  add(columns.astar_all_ms, All_ms(grid, cost, start, goal, "astar", false));
  const double least_cost = SearchCost::InCells(to_goal[map.Index(start)]);
  add(columns.astar_above_percent, 100 * (astar.cost_cells / least_cost - 1));
  Points line;
  add(columns.any_angle_ms, BestTime_ms([&] {
        line = Tighten(map, Centres(FindPath(map, start, goal, Steps::kAnyAngle).cells));
      }));
  add(columns.any_angle_all_ms, All_ms(grid, cost, start, goal, "any_angle", true));
  const Points optimum = Tighten(map, Centres(ManyDirectionsPath(map, start, to_goal)));
  add(columns.any_angle_above_percent, 100 * (CostOf(map, line) / CostOf(map, optimum) - 1));
  const double astar_length = LengthOf(Centres(astar.cells));
  add(columns.shorter_percent, 100 * (1 - LengthOf(line) / astar_length));
  add(columns.optimum_shorter_percent, 100 * (1 - LengthOf(optimum) / astar_length));
  const double shortest = FindPath(map_of_lengths, start, goal, Steps::kCellToCell).cost_cells;
  add(columns.shorter_than_published_percent, 100 * (1 - LengthOf(line) / shortest));
  add(columns.cheaper_percent, 100 * (1 - CostOf(map, line) / astar.cost_cells));
}

void BenchFloor(const std::string& name, double side_m, double angle_rad, double clearance_weight) {
  const OccupancyGrid grid = OfficeFloor(1, side_m).ToGrid(100, 0.05, angle_rad);
  CostOptions cost;
  cost.clearance_weight = clearance_weight;
  if (clearance_weight == 0) cost.margin_weight = 0;
  CostMap map;
  const double map_ms =
      BestWallTime_ms([&] { map = MakeCostMap(grid, cost, kRadius_m, kNumThreads); });
  CostOptions length_alone = cost;
  length_alone.clearance_weight = length_alone.margin_weight = 0;
  const CostMap map_of_lengths = MakeCostMap(grid, length_alone, kRadius_m, kNumThreads);
  Random random(3);
  Columns columns;
  while (columns.NumRoutes() < kNumRoutes) {
    const Eigen::Vector2i start = RandomFreeCell(random, map);
    const Eigen::Vector2i goal = RandomFreeCell(random, map);
    const SearchResult astar = FindPath(map, start, goal, Steps::kCellToCell);
    const double length_m = LengthOf(Centres(astar.cells)) * map.resolution_m;
    if (!astar.found || length_m < 85 || length_m > 95) continue;
    BenchRoute(grid, cost, map, map_of_lengths, start, goal, columns);
  }
  fmt::print("| {} | {:.0f} | {:.0f} |", name, map_ms, columns.dijkstra_ms.Mean());
  for (const Column* times : {&columns.astar_ms, &columns.astar_all_ms}) {
    fmt::print(" {:.0f} ({:.0f}) |", times->Mean(), times->Max());
  }
  fmt::print(" {:.2f} |", columns.astar_above_percent.Max());
  for (const Column* times : {&columns.any_angle_ms, &columns.any_angle_all_ms}) {
    fmt::print(" {:.0f} ({:.0f}) |", times->Mean(), times->Max());
  }
  const Column& above = columns.any_angle_above_percent;
  fmt::print(" {:.2f} ({:.2f}) |", above.Mean(), above.Max());
  for (const Column* gain : {&columns.shorter_percent,
                             &columns.optimum_shorter_percent,
                             &columns.cheaper_percent,
                             &columns.shorter_than_published_percent}) {
    fmt::print(" {:.1f} ({:.1f}) |", gain->Mean(), gain->Min());
  }
  fmt::print("\n");
}

}  // namespace
}  // namespace nightmap

int main(int, char**) {
  fmt::print(
      "| floor | cost map (ms) | Dijkstra (ms) | A*: search (ms) | all (ms) | above the optimum "
      "(%) "
      "| any-angle: search (ms) | all (ms) | above the optimum (%) | shorter than A* (%) | the "
      "optimum is (%) | cheaper than A* (%) | shorter than A* as published (%) |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: "
      "|\n");
  nightmap::BenchFloor("along the grid", 100, 0, 2);
  nightmap::BenchFloor("turned by 20 degrees", 78, 0.35, 2);
  nightmap::BenchFloor("along the grid, shortest", 100, 0, 0);
  nightmap::BenchFloor("turned by 20 degrees, shortest", 78, 0.35, 0);
}
