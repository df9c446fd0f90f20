// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/widest_way.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace nightmap {
namespace {

// Reaches cells in falling order of the room on the widest way to them.
class WidestWay {
 public:
  WidestWay(const OccupancyGrid& grid, const CostMap& map, bool unknown_is_obstacle)
      : grid_(grid),
        map_(map),
        unknown_is_obstacle_(unknown_is_obstacle),
        parents_(grid.cells.size(), kNotReached) {
    const double cells = map.robot_radius_m / map.resolution_m;
    enough_ = static_cast<std::int32_t>(std::ceil(std::min(cells * cells, kMaxEnough)));
    open_.resize(static_cast<std::size_t>(enough_) + 1);
  }

  std::optional<Bottleneck> Find(const Eigen::Vector2i& from, const Eigen::Vector2i& to) {
    if (!IsOpen(from) || !IsOpen(to)) return std::nullopt;
    Reach(from, IndexOf(from), enough_);
    for (std::int32_t room = enough_; room >= 0; --room) {
      // Cells that are reached meanwhile have the same room or less.
      auto& cells = open_[static_cast<std::size_t>(room)];
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const Eigen::Vector2i cell = cells[i];
        if (cell == to) return NarrowestTo(to);
        for (const auto& [dx, dy] : kSides) {
          const Eigen::Vector2i next = cell + Eigen::Vector2i(dx, dy);
          if (IsOpen(next) && parents_[IndexOf(next)] == kNotReached) {
            Reach(next, IndexOf(cell), room);
          }
        }
      }
    }
    return std::nullopt;
  }

 private:
  static constexpr std::array<std::array<int, 2>, 4> kSides = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  static constexpr std::size_t kNotReached = static_cast<std::size_t>(-1);
  static constexpr double kMaxEnough = 4e6;

  bool IsOpen(const Eigen::Vector2i& cell) const {
    return map_.Contains(cell) && !IsObstacle(grid_, cell, unknown_is_obstacle_);
  }
  std::size_t IndexOf(const Eigen::Vector2i& cell) const { return grid_.Index(cell.x(), cell.y()); }
  std::int32_t Room(const Eigen::Vector2i& cell) const {
    return map_.distances.Squared(cell, enough_);
  }

  void Reach(const Eigen::Vector2i& cell, std::size_t parent, std::int32_t room_of_way) {
    parents_[IndexOf(cell)] = parent;
    open_[static_cast<std::size_t>(std::min(room_of_way, Room(cell)))].push_back(cell);
  }

  Bottleneck NarrowestTo(const Eigen::Vector2i& to) const {
    Eigen::Vector2i narrowest = to;
    const auto width = static_cast<std::size_t>(grid_.width);
    for (std::size_t at = IndexOf(to); parents_[at] != at; at = parents_[at]) {
      const Eigen::Vector2i cell(static_cast<int>(at % width), static_cast<int>(at / width));
      if (Room(cell) < Room(narrowest)) narrowest = cell;
    }
    return {narrowest, map_.resolution_m * std::sqrt(static_cast<double>(Room(narrowest)))};
  }

  const OccupancyGrid& grid_;
  const CostMap& map_;
  bool unknown_is_obstacle_;
  std::int32_t enough_ = 0;  // squared distance in cells that the map's robot needs
  std::vector<std::size_t> parents_;
  std::vector<std::vector<Eigen::Vector2i>> open_;  // by room
};

}  // namespace

std::optional<Bottleneck> FindBottleneck(const OccupancyGrid& grid,
                                         const CostMap& map,
                                         bool unknown_is_obstacle,
                                         const Eigen::Vector2i& from,
                                         const Eigen::Vector2i& to) {
  return WidestWay(grid, map, unknown_is_obstacle).Find(from, to);
}

}  // namespace nightmap
