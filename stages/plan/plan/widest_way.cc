// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/widest_way.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace nightmap {
namespace {

constexpr std::array<std::array<int, 2>, 4> kSides = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
constexpr std::size_t kNotReached = static_cast<std::size_t>(-1);
constexpr double kMaxEnough = 4e6;

class WidestWay {
 public:
  explicit WidestWay(const CostMap& map) : map_(map) {
    const double cells = map.robot_radius_m / map.resolution_m;
    enough_ = static_cast<std::int32_t>(std::ceil(std::min(cells * cells, kMaxEnough)));
  }

  std::vector<Bottleneck> Find(const Eigen::Vector2i& from, const Eigen::Vector2i& to) {
    if (!IsOpen(from) || !IsOpen(to)) return {};
    const std::int32_t room = RoomOnTheWay(from, to);
    if (room < 0) return {};
    FindWay(from, to, room);
    return NarrowPlacesTo(to);
  }

 private:
  bool IsOpen(const Eigen::Vector2i& cell) const {
    return map_.Contains(cell) && !map_.distances.IsObstacle(cell);
  }
  std::int32_t Room(const Eigen::Vector2i& cell) const {
    return map_.distances.Squared(cell, enough_);
  }

  // Calls visit(next) for the open neighbours that were not reached, and notes that they are.
  template <typename Visit>
  void Reach(const Eigen::Vector2i& cell, std::int32_t min_room, const Visit& visit) {
    for (const auto& [dx, dy] : kSides) {
      const Eigen::Vector2i next = cell + Eigen::Vector2i(dx, dy);
      if (!IsOpen(next) || parents_[map_.Index(next)] != kNotReached || Room(next) < min_room)
        continue;
      parents_[map_.Index(next)] = map_.Index(cell);
      visit(next);
    }
  }

  void Start(const Eigen::Vector2i& from) {
    parents_.assign(map_.Size(), kNotReached);
    parents_[map_.Index(from)] = map_.Index(from);
  }

  // The room of the narrowest cell of the widest way; -1 when there is no way. Reaches cells in
  // falling order of the room on the widest way to them.
  std::int32_t RoomOnTheWay(const Eigen::Vector2i& from, const Eigen::Vector2i& to) {
    Start(from);
    std::vector<std::vector<Eigen::Vector2i>> open(static_cast<std::size_t>(enough_) + 1);
    open[static_cast<std::size_t>(Room(from))].push_back(from);
    for (std::int32_t room = enough_; room >= 0; --room) {
      // Cells that are reached meanwhile have the same room or less.
      auto& cells = open[static_cast<std::size_t>(room)];
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const Eigen::Vector2i cell = cells[i];
        if (cell == to) return room;
        Reach(cell, 0, [&](const Eigen::Vector2i& next) {
          open[static_cast<std::size_t>(std::min(room, Room(next)))].push_back(next);
        });
      }
    }
    return -1;
  }

  // Leaves in parents_ the way that has that room and the fewest cells that are too narrow: cells
  // that are wide enough are gone through first.
  void FindWay(const Eigen::Vector2i& from, const Eigen::Vector2i& to, std::int32_t room) {
    Start(from);
    std::vector<Eigen::Vector2i> wide = {from};
    std::vector<Eigen::Vector2i> narrow;
    while (parents_[map_.Index(to)] == kNotReached) {
      std::vector<Eigen::Vector2i> next_narrow;
      const auto visit = [&](const Eigen::Vector2i& next) {
        (Room(next) < enough_ ? next_narrow : wide).push_back(next);
      };
      for (const Eigen::Vector2i& cell : narrow) Reach(cell, room, visit);
      for (std::size_t i = 0; i < wide.size(); ++i) {
        const Eigen::Vector2i cell = wide[i];
        Reach(cell, room, visit);
      }
      narrow = std::move(next_narrow);
      wide.clear();
    }
  }

  std::vector<Bottleneck> NarrowPlacesTo(const Eigen::Vector2i& to) const {
    std::vector<Bottleneck> places;
    bool is_inside = false;
    for (std::size_t at = map_.Index(to); parents_[at] != at; at = parents_[at]) {
      const Eigen::Vector2i cell = map_.Cell(at);
      const double clearance_m = map_.resolution_m * std::sqrt(static_cast<double>(Room(cell)));
      const bool was_inside = is_inside;
      is_inside = Room(cell) < enough_;
      if (is_inside && !was_inside) places.push_back({cell, clearance_m});
      if (is_inside && clearance_m < places.back().clearance_m) places.back() = {cell, clearance_m};
    }
    std::ranges::reverse(places);
    return places;
  }

  const CostMap& map_;
  std::int32_t enough_ = 0;           // squared distance in cells that the map's robot needs
  std::vector<std::size_t> parents_;  // of reached cells
};

}  // namespace

std::vector<Bottleneck> FindBottlenecks(const CostMap& map,
                                        const Eigen::Vector2i& from,
                                        const Eigen::Vector2i& to) {
  return WidestWay(map).Find(from, to);
}

}  // namespace nightmap
