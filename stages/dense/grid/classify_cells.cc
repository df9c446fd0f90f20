// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/classify_cells.h"

#include <cmath>
#include <limits>

#include "pipeline/base/parallel.h"
#include "stages/dense/grid/floors.h"
#include "stages/dense/grid/reachable_space.h"

namespace nightmap {
namespace {

constexpr int kSpeckMaxVoxels = 2;  // a column with more occupied voxels is never a speck
constexpr double kTolerance_m = 1e-9;
constexpr double kArmsReach_m = 0.6;      // from a camera to the person who carries it
constexpr double kMinUnseenDrop_m = 0.3;  // depth of free space below the ground that proves a drop

// Content of a column, in smallest voxels.
struct Contents {
  int num_occupied = 0;  // in the obstacle band
  int num_free = 0;      // from the ground to the robot's height, like the next two
  int lowest_free = std::numeric_limits<int>::max();
  int highest_free = std::numeric_limits<int>::min();
  // Voxels from a step above unseen ground to the lowest free one; 0 around a camera.
  int num_hidden = 0;
  bool has_ground = false;
  int drop = 0;             // depth of the free space below a step
  bool has_bottom = false;  // whether that free space ends on something seen

  // Voxels between free ones that no ray reached or crossed.
  int NumUnseen() const {
    return num_free == 0 ? 0 : highest_free - lowest_free + 1 - num_free - num_occupied;
  }
};

class FloorClassifier {
 public:
  FloorClassifier(const GridOptions& options,
                  const Columns& columns,
                  const std::vector<double>& ground_m,
                  double floor_m)
      : options_(options),
        columns_(columns),
        ground_m_(ground_m),
        resolution_m_(columns.resolution_m) {
    result_.height_m = floor_m;
    OccupancyGrid& grid = result_.grid;
    grid.width = columns.area.width;
    grid.height = columns.area.height;
    grid.resolution_m = resolution_m_;
    grid.origin_in_map = resolution_m_ * Eigen::Vector2d(columns.area.min_x, columns.area.min_y);
    grid.cells.assign(columns.area.Size(), kUnknownCell);
  }

  FloorGrid Classify(const std::vector<Eigen::Vector3d>& cameras_in_map, int num_threads) {
    is_around_camera_ = CellsAroundCameras(
        cameras_in_map, ground_m_, kMaxCameraHeight_m, kArmsReach_m, result_.grid);
    ParallelFor(static_cast<std::size_t>(columns_.area.height), num_threads, [&](std::size_t y) {
      const auto width = static_cast<std::size_t>(columns_.area.width);
      for (std::size_t cell = y * width; cell < (y + 1) * width; ++cell) {
        result_.grid.cells[cell] = StateOf(ContentsOf(cell));
      }
    });
    RemoveSpecks();
    result_.num_unvisited_cells =
        RemoveUnvisited(cameras_in_map, ground_m_, kMaxCameraHeight_m, result_.grid);
    MarkDrops();
    CountGround();
    return std::move(result_);
  }

 private:
  Contents ContentsOf(std::size_t cell) const {
    const double ground_m = ground_m_[cell];
    const double step_m = options_.max_step_height_m;
    const auto within = [&](double low_m, double high_m) {
      return VoxelsWithin(ground_m + low_m, ground_m + high_m, resolution_m_);
    };
    const HeightRange robot = within(0, options_.robot_height_m);
    const HeightRange band{within(step_m, options_.robot_height_m).min, robot.max};
    const HeightRange level{within(-step_m, 0).min, band.min - 1};
    Contents contents;
    for (const ColumnRun& run : columns_.Of(cell)) {
      if (run.occupied) {
        contents.num_occupied += band.Overlap(run.begin, run.end);
        contents.has_ground |= level.Overlap(run.begin, run.end) > 0;
        continue;
      }
      const int num_free = robot.Overlap(run.begin, run.end);
      if (num_free == 0) continue;
      contents.num_free += num_free;
      contents.lowest_free = std::min(contents.lowest_free, std::max(run.begin, robot.min));
      contents.highest_free = std::max(contents.highest_free, std::min(run.end - 1, robot.max));
    }
    if (contents.num_free > 0 && !contents.has_ground) {
      if (!is_around_camera_[cell]) {
        contents.num_hidden = std::max(0, contents.lowest_free - band.min);
      }
      FindDrop(cell, level.min, contents);
    }
    return contents;
  }

  // Follows free space downwards across short unseen parts.
  void FindDrop(std::size_t cell, int step_bottom, Contents& contents) const {
    const int max_gap = static_cast<int>(options_.max_unseen_m / resolution_m_ + kTolerance_m);
    int bottom = contents.lowest_free;
    const auto runs = columns_.Of(cell);
    for (auto run = runs.rbegin(); run != runs.rend(); ++run) {
      if (run->begin >= contents.lowest_free) continue;
      if (run->end < bottom - max_gap) break;
      if (run->occupied) {
        contents.has_bottom = true;
        break;
      }
      bottom = run->begin;
    }
    contents.drop = std::max(0, step_bottom - bottom);
  }

  // A little free space that ends unseen may lie above the unseen ground of a ramp.
  bool IsDrop(const Contents& contents) const {
    if (contents.drop == 0) return false;
    return contents.has_bottom || resolution_m_ * contents.drop >= kMinUnseenDrop_m - kTolerance_m;
  }

  CellValue SeenState(const Contents& contents) const {
    const bool is_seen = contents.has_ground || contents.num_free > 0;
    const bool is_gap = resolution_m_ * contents.NumUnseen() > options_.max_unseen_m + kTolerance_m;
    const bool is_hidden =
        resolution_m_ * contents.num_hidden > options_.max_hidden_m + kTolerance_m;
    return is_seen && !is_gap && !is_hidden && !IsDrop(contents) ? kFreeCell : kUnknownCell;
  }

  CellValue StateOf(const Contents& contents) const {
    const bool is_occupied = contents.num_occupied >= options_.min_occupied_voxels;
    return is_occupied ? kOccupiedCell : SeenState(contents);
  }

  // Counts the cells in a state among the eight around.
  int CountAround(std::size_t cell, CellValue state) const {
    const OccupancyGrid& grid = result_.grid;
    const int x = static_cast<int>(cell) % grid.width;
    const int y = static_cast<int>(cell) / grid.width;
    int count = 0;
    for (int i = 0; i < 9; ++i) {
      const Eigen::Vector2i near(x + i % 3 - 1, y + i / 3 - 1);
      count += i != 4 && grid.Contains(near) && grid.At(near) == state ? 1 : 0;
    }
    return count;
  }

  // A lone cell is a speck only if its column is low too, so that a thin pole stays an obstacle.
  void RemoveSpecks() {
    std::vector<std::size_t> specks;
    for (std::size_t cell = 0; cell < result_.grid.cells.size(); ++cell) {
      if (result_.grid.cells[cell] == kOccupiedCell &&
          CountAround(cell, kOccupiedCell) < options_.speck_min_neighbors &&
          ContentsOf(cell).num_occupied <= kSpeckMaxVoxels) {
        specks.push_back(cell);
      }
    }
    for (const std::size_t cell : specks) result_.grid.cells[cell] = SeenState(ContentsOf(cell));
    result_.num_removed_specks = specks.size();
  }

  void MarkDrops() {
    std::vector<std::size_t> drops;
    for (std::size_t cell = 0; cell < result_.grid.cells.size(); ++cell) {
      if (result_.grid.cells[cell] == kUnknownCell && CountAround(cell, kFreeCell) > 0 &&
          IsDrop(ContentsOf(cell))) {
        drops.push_back(cell);
      }
    }
    for (const std::size_t cell : drops) result_.grid.cells[cell] = kOccupiedCell;
    result_.num_drop_cells = drops.size();
  }

  void CountGround() {
    for (std::size_t cell = 0; cell < ground_m_.size(); ++cell) {
      if (!ContentsOf(cell).has_ground) continue;
      ++result_.num_ground_cells;
      if (ground_m_[cell] != result_.height_m) ++result_.num_ramp_cells;
    }
  }

  const GridOptions& options_;
  const Columns& columns_;
  const std::vector<double>& ground_m_;
  const double resolution_m_;
  std::vector<bool> is_around_camera_;  // by cell
  FloorGrid result_;
};

}  // namespace

FloorGrid ClassifyFloor(const GridOptions& options,
                        const Columns& columns,
                        const std::vector<double>& ground_m,
                        double floor_m,
                        const std::vector<Eigen::Vector3d>& cameras_in_map,
                        int num_threads) {
  return FloorClassifier(options, columns, ground_m, floor_m).Classify(cameras_in_map, num_threads);
}

}  // namespace nightmap
