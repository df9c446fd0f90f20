// SPDX-License-Identifier: Apache-2.0
// Times path planning on made-up office floors of 100 m x 100 m at 5 cm, along the grid and turned
// against it, on random routes of about 90 m, and prints a table:
//   ninja -C build bench_plan && build/bench_plan
// Times are CPU time on one thread, the best of several repeats, as mean (and worst) of the routes:
// of the search on the cost map ("search"; of the any-angle planner with pulling tight, which its
// path has always), and of everything from the grid to the path ("all", RunPlan: cost map with its
// distance transform, search, pulling tight, checks). The reference is Dijkstra's algorithm with a
// heap of the standard library.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <queue>
#include <vector>

#include "stages/plan/any_angle.h"
#include "stages/plan/plan.h"
#include "stages/plan/search.h"
#include "stages/plan/segment.h"
#include "stages/plan/shorten.h"
#include "tests/stages/plan/office_floor.h"
#include "tests/stages/plan/scene.h"

namespace nightmap {
namespace {

constexpr int kNumRoutes = 10;
constexpr int kNumRepeats = 5;
constexpr double kRadius_m = 0.25;

using Points = std::vector<Eigen::Vector2d>;

double CpuTime_ms() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

double BestTime_ms(const std::function<void()>& work, int num_repeats = kNumRepeats) {
  double best_ms = 1e9;
  for (int i = 0; i < num_repeats; ++i) {
    const double start_ms = CpuTime_ms();
    work();
    best_ms = std::min(best_ms, CpuTime_ms() - start_ms);
  }
  return best_ms;
}

std::int64_t DijkstraCost(const CostMap& map,
                          const Eigen::Vector2i& start,
                          const Eigen::Vector2i& goal) {
  using Open = std::pair<std::int64_t, std::size_t>;
  std::vector<std::int64_t> costs(map.Size(), -1);
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  open.emplace(0, map.Index(start));
  while (!open.empty()) {
    const auto [cost, index] = open.top();
    open.pop();
    if (costs[index] >= 0) continue;
    costs[index] = cost;
    if (index == map.Index(goal)) return cost;
    const Eigen::Vector2i cell = map.Cell(index);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Eigen::Vector2i next(cell.x() + dx, cell.y() + dy);
        if (!map.IsFree(next) || !map.IsFree({next.x(), cell.y()}) ||
            !map.IsFree({cell.x(), next.y()}) || costs[map.Index(next)] >= 0) {
          continue;
        }
        const auto length = dx != 0 && dy != 0 ? SearchCost::kDiagonal : SearchCost::kStraight;
        open.emplace(cost + length * (map.costs[index] + map.costs[map.Index(next)]),
                     map.Index(next));
      }
    }
  }
  return -1;
}

Points Centres(const SearchResult& result) {
  Points points;
  for (const auto& cell : result.cells) {
    points.push_back(cell.cast<double>() + Eigen::Vector2d(0.5, 0.5));
  }
  return points;
}

double Length_m(const CostMap& map, const Points& points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length * map.resolution_m;
}

double Cost_m(const CostMap& map, const Points& points) {
  double cost = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    cost += SegmentCost(map, points[i - 1], points[i]);
  }
  return cost * map.resolution_m;
}

double All_ms(const OccupancyGrid& grid,
              const Eigen::Vector2i& start,
              const Eigen::Vector2i& goal,
              const std::string& planner,
              bool shorten) {
  const PlanInputs inputs{grid, {}, {}};
  PlanOptions options;
  const auto text = [&](const Eigen::Vector2i& cell) {
    const Eigen::Vector2d point = grid.CenterInMap(cell);
    return fmt::format("{:.3f},{:.3f}", point.x(), point.y());
  };
  options.start = text(start);
  options.goal = text(goal);
  options.planner = planner;
  options.shorten = shorten;
  return BestTime_ms([&] {
    Progress progress("plan", false);
    RunPlan(options, inputs, progress, 1);
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

void BenchFloor(const std::string& name, double side_m, double angle_rad) {
  const OccupancyGrid grid = OfficeFloor(1, side_m).ToGrid(100, 0.05, angle_rad);
  CostMap map;
  const double map_ms = BestTime_ms([&] { map = MakeCostMap(grid, {}, kRadius_m, 1); });
  Random random(3);
  Column dijkstra_ms, astar_ms, astar_all_ms, any_angle_ms, any_angle_all_ms;
  Column length_m, above_percent, shorter_percent, cheaper_percent;
  while (length_m.values.size() < kNumRoutes) {
    const Eigen::Vector2i start = RandomFreeCell(random, map);
    const Eigen::Vector2i goal = RandomFreeCell(random, map);
    SearchResult astar = FindPath(map, start, goal);
    const double astar_m = Length_m(map, Centres(astar));
    if (!astar.found || astar_m < 85 || astar_m > 95) continue;
    std::int64_t optimum = 0;
    Points line;
    length_m.values.push_back(astar_m);
    dijkstra_ms.values.push_back(BestTime_ms([&] { optimum = DijkstraCost(map, start, goal); }, 1));
    astar_ms.values.push_back(BestTime_ms([&] { astar = FindPath(map, start, goal); }));
    any_angle_ms.values.push_back(
        BestTime_ms([&] { line = Tighten(map, Centres(FindAnyAnglePath(map, start, goal))); }));
    astar_all_ms.values.push_back(All_ms(grid, start, goal, "astar", false));
    any_angle_all_ms.values.push_back(All_ms(grid, start, goal, "any_angle", true));
    above_percent.values.push_back(100 * (astar.cost_cells / SearchCost::InCells(optimum) - 1));
    shorter_percent.values.push_back(100 * (1 - Length_m(map, line) / astar_m));
    cheaper_percent.values.push_back(
        100 * (1 - Cost_m(map, line) / (astar.cost_cells * map.resolution_m)));
  }
  fmt::print(
      "| {} | {:.0f} | {:.0f} | {:.0f} ({:.0f}) | {:.0f} ({:.0f}) | {:.2f} | {:.0f} ({:.0f}) | "
      "{:.0f} ({:.0f}) | {:.1f} ({:.1f}) | {:.1f} ({:.1f}) |\n",
      name,
      map_ms,
      dijkstra_ms.Mean(),
      astar_ms.Mean(),
      astar_ms.Max(),
      astar_all_ms.Mean(),
      astar_all_ms.Max(),
      above_percent.Max(),
      any_angle_ms.Mean(),
      any_angle_ms.Max(),
      any_angle_all_ms.Mean(),
      any_angle_all_ms.Max(),
      shorter_percent.Mean(),
      shorter_percent.Min(),
      cheaper_percent.Mean(),
      cheaper_percent.Min());
}

}  // namespace
}  // namespace nightmap

int main() {
  fmt::print(
      "| floor | cost map (ms) | Dijkstra (ms) | A*: search (ms) | all (ms) | above the optimum "
      "(%) | "
      "any-angle: search (ms) | all (ms) | shorter than A* (%) | cheaper than A* (%) |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  nightmap::BenchFloor("along the grid", 100, 0);
  nightmap::BenchFloor("turned by 20 degrees", 78, 0.35);
}
