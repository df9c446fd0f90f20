// SPDX-License-Identifier: Apache-2.0
// A large made-up office floor for benchmarks and property tests of the plan stage.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

// Corridors 2.4 m wide cross every 25 m; what is between them is divided into rooms, with doors of
// 0.9 m to 1.4 m in every wall, and furnished. A square of `side_m`, drawn in cells of 2.5 cm.
class OfficeFloor {
 public:
  OfficeFloor(std::uint64_t seed, double side_m)
      : random_(seed), side_(ToDots(side_m)), dots_(Size(), kFreeCell) {
    for (int y = 0; y < side_; y += ToDots(kBlock_m)) {
      for (int x = 0; x < side_; x += ToDots(kBlock_m)) {
        const int extent = ToDots(kBlock_m - kCorridor_m);
        Divide({x, y, std::min(x + extent, side_ - 1), std::min(y + extent, side_ - 1)});
      }
    }
    Frame({0, 0, side_ - 1, side_ - 1});
  }

  // Turned about its centre by `angle_rad` on a grid of `grid_side_m`; outside of it is unknown.
  OccupancyGrid ToGrid(double grid_side_m, double resolution_m, double angle_rad) const {
    const int side = static_cast<int>(std::lround(grid_side_m / resolution_m));
    OccupancyGrid grid{side, side, resolution_m, {-grid_side_m / 2, -grid_side_m / 2}, {}};
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        const Eigen::Vector2d point = grid.CenterInMap({x, y});
        grid.cells.push_back(At(std::cos(angle_rad) * point.x() + std::sin(angle_rad) * point.y(),
                                std::cos(angle_rad) * point.y() - std::sin(angle_rad) * point.x()));
      }
    }
    return grid;
  }

 private:
  static constexpr double kDot_m = 0.025;
  static constexpr double kBlock_m = 25;
  static constexpr double kCorridor_m = 2.4;
  static constexpr double kMinRoom_m = 3.5;
  static constexpr double kMaxRoom_m = 9;
  static constexpr double kWall_m = 0.15;

  struct Box {
    int x0, y0, x1, y1;  // dots, all inside
    int Width() const { return x1 - x0; }
    int Height() const { return y1 - y0; }
  };

  static int ToDots(double length_m) { return static_cast<int>(std::lround(length_m / kDot_m)); }
  std::size_t Size() const {
    return static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_);
  }
  double Draw(double min, double max) { return random_.Uniform(min, max); }

  std::uint8_t At(double x_m, double y_m) const {
    const int x = static_cast<int>(std::floor(x_m / kDot_m)) + side_ / 2;
    const int y = static_cast<int>(std::floor(y_m / kDot_m)) + side_ / 2;
    if (x < 0 || y < 0 || x >= side_ || y >= side_) return kUnknownCell;
    return dots_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) +
                 static_cast<std::size_t>(x)];
  }

  void Fill(const Box& box, CellValue value) {
    for (int y = std::max(box.y0, 0); y <= std::min(box.y1, side_ - 1); ++y) {
      for (int x = std::max(box.x0, 0); x <= std::min(box.x1, side_ - 1); ++x) {
        dots_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) +
              static_cast<std::size_t>(x)] = value;
      }
    }
  }

  // The four walls of a box.
  void Frame(const Box& box) {
    const int wall = ToDots(kWall_m);
    Fill({box.x0, box.y0, box.x1, box.y0 + wall}, kOccupiedCell);
    Fill({box.x0, box.y1 - wall, box.x1, box.y1}, kOccupiedCell);
    Fill({box.x0, box.y0, box.x0 + wall, box.y1}, kOccupiedCell);
    Fill({box.x1 - wall, box.y0, box.x1, box.y1}, kOccupiedCell);
  }

  void Divide(const Box& box) {
    const int min_room = ToDots(kMinRoom_m);
    const bool across = box.Width() > box.Height();
    const int extent = across ? box.Width() : box.Height();
    if (extent < 2 * min_room || (extent < ToDots(kMaxRoom_m) && Draw(0, 1) < 0.5)) {
      Furnish(box);
      Frame(box);
      Doors(box);
      return;
    }
    const int at = static_cast<int>(Draw(min_room, extent - min_room));
    const int wall = ToDots(kWall_m);
    Box first = box;
    Box second = box;
    (across ? first.x1 : first.y1) = (across ? box.x0 : box.y0) + at;
    (across ? second.x0 : second.y0) = (across ? box.x0 : box.y0) + at - wall;
    Divide(first);
    Divide(second);
  }

  // Tables and cupboards on about a seventh of the room.
  void Furnish(const Box& box) {
    const int num_pieces = static_cast<int>(box.Width() * kDot_m * box.Height() * kDot_m / 7);
    for (int i = 0; i < num_pieces; ++i) {
      const int x = static_cast<int>(Draw(box.x0, box.x1));
      const int y = static_cast<int>(Draw(box.y0, box.y1));
      const Box piece = {x, y, x + ToDots(Draw(0.3, 1.8)), y + ToDots(Draw(0.3, 1.2))};
      if (piece.x1 < box.x1 && piece.y1 < box.y1) Fill(piece, kOccupiedCell);
    }
  }

  // One door a wall, and the space before and behind it.
  void Doors(const Box& box) {
    const int reach = ToDots(0.9);
    const auto along = [&](int from, int to, int width) {
      return static_cast<int>(Draw(from + ToDots(0.4), to - ToDots(0.4) - width));
    };
    for (const int y : {box.y0, box.y1}) {
      const int width = ToDots(Draw(0.9, 1.4));
      const int x = along(box.x0, box.x1, width);
      Fill({x, y - reach, x + width, y + reach}, kFreeCell);
    }
    for (const int x : {box.x0, box.x1}) {
      const int width = ToDots(Draw(0.9, 1.4));
      const int y = along(box.y0, box.y1, width);
      Fill({x - reach, y, x + reach, y + width}, kFreeCell);
    }
  }

  Random random_;
  int side_;
  std::vector<std::uint8_t> dots_;
};

}  // namespace nightmap
