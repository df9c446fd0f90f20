// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/floors.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

namespace nightmap {
namespace {

// Smallest seen level area of a floor above or below the map's.
constexpr double kMinFloorArea_m2 = 3.0;
// Smallest height between two floors; nearer level surfaces are furniture.
constexpr double kMinFloorDistance_m = 2.0;
constexpr int kMaxGap = 1;  // unseen voxels between a surface and the free space above it

bool IsSupport(std::span<const ColumnRun> runs, std::size_t at, const HeightRange& room) {
  const int top = runs[at].end - 1;
  if (!runs[at].occupied || at + 1 == runs.size()) return false;
  const ColumnRun& above = runs[at + 1];
  if (above.occupied || above.begin > top + 1 + kMaxGap) return false;
  return std::ranges::none_of(runs.subspan(at + 1), [&](const ColumnRun& run) {
    return run.occupied && room.Overlap(run.begin - top, run.end - top) > 0;
  });
}

// Number of supports by top voxel.
class HeightHistogram {
 public:
  explicit HeightHistogram(const Supports& supports) {
    for (const int top : supports.tops) ++counts_[top];
  }
  std::size_t Near(int top) const { return At(top - 1) + At(top) + At(top + 1); }

  // The voxel with the most supports within one voxel of it, among those that `fits` accepts; ties:
  // the lowest.
  template <typename Fits>
  std::optional<int> Peak(const Fits& fits) const {
    std::optional<int> best;
    for (const auto& [top, count] : counts_) {
      if (fits(top) && (!best || Near(top) > Near(*best))) best = top;
    }
    return best;
  }

  double MeanTop(int top) const {
    const auto weighted = static_cast<double>(At(top + 1)) - static_cast<double>(At(top - 1));
    return top + weighted / static_cast<double>(Near(top));
  }

 private:
  std::size_t At(int top) const {
    const auto found = counts_.find(top);
    return found == counts_.end() ? 0 : found->second;
  }
  std::map<int, std::size_t> counts_;
};

bool HasCamera(const std::vector<Eigen::Vector3d>& cameras_in_map, double floor_m) {
  return cameras_in_map.empty() ||
         std::ranges::any_of(cameras_in_map, [&](const Eigen::Vector3d& camera) {
           return camera.z() > floor_m && camera.z() < floor_m + kMaxCameraHeight_m;
         });
}

}  // namespace

Supports FindSupports(const GridOptions& options, const Columns& columns) {
  // Heights are relative to the surface's voxel, whose centre counts as the surface.
  const double resolution_m = columns.resolution_m;
  HeightRange room = VoxelsWithin(options.max_step_height_m + resolution_m / 2,
                                  options.robot_height_m + resolution_m / 2,
                                  resolution_m);
  room.min = std::max(room.min, 1);
  Supports supports{{0}, {}};
  for (std::size_t i = 0; i < columns.area.Size(); ++i) {
    const auto runs = columns.Of(i);
    for (std::size_t at = 0; at < runs.size(); ++at) {
      if (IsSupport(runs, at, room)) supports.tops.push_back(runs[at].end - 1);
    }
    supports.first.push_back(supports.tops.size());
  }
  return supports;
}

std::vector<double> FindFloors(const Columns& columns,
                               const Supports& supports,
                               const std::vector<Eigen::Vector3d>& cameras_in_map) {
  const double cell_m2 = columns.resolution_m * columns.resolution_m;
  const HeightHistogram histogram(supports);
  std::vector<double> floors_m = {0.0};
  std::vector<double> unvisited_m;
  const auto is_apart = [&](int top) {
    const auto is_near = [&](double other_m) {
      return std::abs(SurfaceHeight_m(top, columns.resolution_m) - other_m) < kMinFloorDistance_m;
    };
    return std::ranges::none_of(floors_m, is_near) && std::ranges::none_of(unvisited_m, is_near);
  };
  while (const auto top = histogram.Peak(is_apart)) {
    if (cell_m2 * static_cast<double>(histogram.Near(*top)) < kMinFloorArea_m2) break;
    const double height_m = (histogram.MeanTop(*top) + 0.5) * columns.resolution_m;
    (HasCamera(cameras_in_map, height_m) ? floors_m : unvisited_m).push_back(height_m);
  }
  std::ranges::sort(floors_m);
  return floors_m;
}

}  // namespace nightmap
