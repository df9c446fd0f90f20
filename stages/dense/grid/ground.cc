// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nightmap {
namespace {

constexpr double kFillReach_m = 0.75;
constexpr double kBridge_m = 1.5;    // longest unseen ground behind which a ramp continues
constexpr double kMaxSlope = 0.36;   // of ramps, measured from where they leave level ground
constexpr int kNumSmoothings = 100;  // of the ground filled in beside ramps
constexpr double kStepTolerance_m = 1e-9;
constexpr int kNoSupport = std::numeric_limits<int>::min();

class GroundFinder {
 public:
  GroundFinder(const GridOptions& options,
               const Columns& columns,
               const Supports& supports,
               const std::vector<double>& floors_m,
               std::size_t floor_idx)
      : options_(options),
        columns_(columns),
        area_(columns.area),
        resolution_m_(columns.resolution_m),
        supports_(supports),
        floor_m_(floors_m[floor_idx]),
        tops_(area_.Size(), kNoSupport),
        bridges_(area_.Size()),
        ways_(area_.Size()),
        is_of_other_floor_(area_.Size(), false) {
    const double step_m = options.max_step_height_m;
    if (floor_idx > 0) lowest_m_ = floors_m[floor_idx - 1] + step_m;
    if (floor_idx + 1 < floors_m.size()) highest_m_ = floors_m[floor_idx + 1] - step_m;
  }

  std::vector<double> Find() {
    FollowRamps(LevelCells());
    DropSmallRamps();
    return Fill();
  }

 private:
  double Height_m(int top) const { return SurfaceHeight_m(top, resolution_m_); }
  bool IsLevel(int top) const {
    return std::abs(Height_m(top) - floor_m_) <= options_.max_step_height_m + kStepTolerance_m;
  }
  bool IsRamp(std::size_t cell) const { return tops_[cell] != kNoSupport && !IsLevel(tops_[cell]); }

  // Calls visit(neighbour) for the cells that share a side.
  template <typename Visit>
  void ForNeighbours(std::size_t cell, const Visit& visit) const {
    const auto width = static_cast<std::size_t>(area_.width);
    const std::size_t x = cell % width;
    if (x > 0) visit(cell - 1);
    if (x + 1 < width) visit(cell + 1);
    if (cell >= width) visit(cell - width);
    if (cell + width < tops_.size()) visit(cell + width);
  }

  // The level support of a column; if there are several, the one nearest to the floor's height.
  std::vector<std::size_t> LevelCells() {
    std::vector<std::size_t> cells;
    for (std::size_t cell = 0; cell < tops_.size(); ++cell) {
      for (const int top : supports_.Of(cell)) {
        const bool is_nearer =
            tops_[cell] == kNoSupport ||
            std::abs(Height_m(top) - floor_m_) < std::abs(Height_m(tops_[cell]) - floor_m_);
        if (IsLevel(top) && is_nearer) tops_[cell] = top;
      }
      if (tops_[cell] == kNoSupport) continue;
      ways_[cell].level_top = tops_[cell];
      cells.push_back(cell);
    }
    return cells;
  }

  // Unseen ground below seen free space: the support before it, and the distance back to that.
  struct Bridge {
    int from_top = kNoSupport;
    int num_cells = std::numeric_limits<int>::max();
  };

  // Path from level ground to a cell; anything steeper than a ramp is furniture.
  struct Way {
    int level_top = kNoSupport;
    int num_cells = 0;
  };

  int Voxels(double height_m) const {
    return static_cast<int>(std::floor(height_m / resolution_m_ + kStepTolerance_m));
  }
  // How far the ground may have risen or fallen, in voxels.
  int MaxRise(int num_unseen_cells) const {
    return Voxels(options_.max_step_height_m + kMaxSlope * num_unseen_cells * resolution_m_);
  }

  // The support of a column that is reached from an adjacent one, or across unseen ground.
  int ReachedTop(std::size_t cell, const Bridge& from) const {
    for (const int top : supports_.Of(cell)) {
      if (std::abs(top - from.from_top) <= MaxRise(from.num_cells)) return top;
    }
    return kNoSupport;
  }
  bool IsOfOtherFloor(int top) const {
    return Height_m(top) <= lowest_m_ || Height_m(top) >= highest_m_;
  }

  // Whether a robot could stand in a column on unseen ground: its space is free, has no obstacle
  // and no drop, at whatever reachable height the ground is.
  bool CanBridge(std::size_t cell, const Bridge& to) const {
    const int rise = MaxRise(to.num_cells);
    const HeightRange way{to.from_top + rise + 1,
                          to.from_top + Voxels(options_.robot_height_m) - rise};
    bool has_room = false;
    for (const ColumnRun& run : columns_.Of(cell)) {
      if (way.Overlap(run.begin, run.end) == 0) continue;
      if (run.occupied || run.begin < to.from_top + 1 - rise) return false;
      has_room = true;
    }
    return has_room && to.num_cells * resolution_m_ <= kBridge_m;
  }

  // Only ramps continue under unseen ground; the height of level ground is known.
  void TryBridge(std::size_t cell, const Bridge& from, std::vector<std::size_t>& queue) {
    const Bridge to{from.from_top, from.num_cells + 1};
    if (IsLevel(from.from_top) || to.num_cells >= bridges_[cell].num_cells) return;
    if (!CanBridge(cell, to)) return;
    bridges_[cell] = to;
    queue.push_back(cell);
  }

  void FollowRamps(std::vector<std::size_t> queue) {
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const std::size_t at = queue[next];
      const Bridge from = tops_[at] == kNoSupport ? bridges_[at] : Bridge{tops_[at], 0};
      ForNeighbours(at, [&](std::size_t cell) {
        if (tops_[cell] != kNoSupport) return;
        const Way way{ways_[at].level_top, ways_[at].num_cells + 1};
        const int top = ReachedTop(cell, from);
        if (top != kNoSupport && std::abs(top - way.level_top) > MaxRise(way.num_cells)) return;
        ways_[cell] = way;
        if (top == kNoSupport) return TryBridge(cell, from, queue);
        if (IsOfOtherFloor(top)) {
          is_of_other_floor_[cell] = true;
          return;
        }
        tops_[cell] = top;
        queue.push_back(cell);
      });
    }
  }

  void DropSmallRamps() {
    const double cell_m2 = resolution_m_ * resolution_m_;
    std::vector<bool> is_done(tops_.size(), false);
    for (std::size_t seed = 0; seed < tops_.size(); ++seed) {
      if (is_done[seed] || !IsRamp(seed)) continue;
      std::vector<std::size_t> patch = {seed};
      is_done[seed] = true;
      for (std::size_t next = 0; next < patch.size(); ++next) {
        ForNeighbours(patch[next], [&](std::size_t cell) {
          if (is_done[cell] || !IsRamp(cell)) return;
          is_done[cell] = true;
          patch.push_back(cell);
        });
      }
      if (cell_m2 * static_cast<double>(patch.size()) >= options_.min_ramp_area_m2) continue;
      for (const std::size_t cell : patch) tops_[cell] = kNoSupport;
    }
  }

  std::vector<double> Fill() const {
    std::vector<double> ground_m(tops_.size(), floor_m_);
    // A ramp that leaves this floor ends at the other floor.
    std::vector<bool> is_done = is_of_other_floor_;
    std::vector<std::size_t> border;
    for (std::size_t cell = 0; cell < tops_.size(); ++cell) {
      if (tops_[cell] == kNoSupport) continue;
      if (!IsLevel(tops_[cell])) ground_m[cell] = Height_m(tops_[cell]);
      is_done[cell] = true;
      border.push_back(cell);
    }
    const int reach = static_cast<int>(std::lround(kFillReach_m / resolution_m_));
    std::vector<std::size_t> filled;
    for (int distance = 0; distance < reach; ++distance) {
      std::vector<std::size_t> next;
      for (const std::size_t from : border) {
        ForNeighbours(from, [&](std::size_t cell) {
          if (is_done[cell]) return;
          is_done[cell] = true;
          ground_m[cell] = ground_m[from];
          next.push_back(cell);
        });
      }
      filled.insert(filled.end(), next.begin(), next.end());
      border = std::move(next);
    }
    Smooth(filled, is_done, ground_m);
    return ground_m;
  }

  // Replaces the filled cells by the mean of their neighbours, so that the ground rises evenly
  // between two parts of a ramp.
  void Smooth(const std::vector<std::size_t>& filled,
              const std::vector<bool>& is_done,
              std::vector<double>& ground_m) const {
    const bool is_level =
        std::ranges::all_of(filled, [&](std::size_t cell) { return ground_m[cell] == floor_m_; });
    for (int i = 0; i < kNumSmoothings && !is_level; ++i) {
      for (const std::size_t cell : filled) {
        double sum_m = 0;
        int count = 0;
        ForNeighbours(cell, [&](std::size_t near) {
          if (!is_done[near] || is_of_other_floor_[near]) return;
          if (std::abs(ground_m[near] - ground_m[cell]) > kMaxSlope * kBridge_m) return;
          sum_m += ground_m[near];
          ++count;
        });
        if (count > 0) ground_m[cell] = sum_m / count;
      }
    }
  }

  const GridOptions& options_;
  const Columns& columns_;
  const Area area_;
  const double resolution_m_;
  const Supports& supports_;
  const double floor_m_;
  double lowest_m_ = -std::numeric_limits<double>::infinity();
  double highest_m_ = std::numeric_limits<double>::infinity();
  std::vector<int> tops_;  // of each cell's ground, or kNoSupport
  std::vector<Bridge> bridges_;
  std::vector<Way> ways_;
  std::vector<bool> is_of_other_floor_;
};

}  // namespace

std::vector<double> FindGround(const GridOptions& options,
                               const Columns& columns,
                               const Supports& supports,
                               const std::vector<double>& floors_m,
                               std::size_t floor_idx) {
  return GroundFinder(options, columns, supports, floors_m, floor_idx).Find();
}

}  // namespace nightmap
