// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/floor_layout.h"

#include <algorithm>
#include <numbers>

#include "pipeline/base/error.h"

namespace nightmap {

namespace {

constexpr int kNumRoomRows = 3;
constexpr double kDoorPosition = 0.36;  // share of the room's width

// South edges of the south corridor, the inner row, the north corridor and the north row.
struct RowHeights {
  double south_corridor, inner, north_corridor, north;
};

RowHeights ComputeRowHeights(const BuildingOptions& options) {
  const double wall = options.wall_thickness_m;
  RowHeights y{};
  y.south_corridor = options.room_depth_m + wall;
  y.inner = y.south_corridor + options.corridor_width_m + wall;
  y.north_corridor = y.inner + options.room_depth_m + wall;
  y.north = y.north_corridor + options.corridor_width_m + wall;
  return y;
}

// Chooses rooms of style 0 from the outer rows first. Their doors are on the same side of the
// robot, so that they can be furnished exactly alike.
int StyleOfRoom(const BuildingOptions& options, int room_idx, int num_columns) {
  constexpr int kRank[kNumRoomRows] = {0, 2, 1};
  const int rank = kRank[room_idx % kNumRoomRows] * num_columns + room_idx / kNumRoomRows;
  return rank < options.num_identical_rooms ? 0 : room_idx + 1;
}

Room MakeRoom(const BuildingOptions& options, const RowHeights& y, int room_idx, int num_columns) {
  const int column = room_idx / kNumRoomRows;
  const int row = room_idx % kNumRoomRows;
  const double x0 = options.corridor_width_m + options.wall_thickness_m +
                    column * (options.room_width_m + options.wall_thickness_m);
  const double y0 = row == 0 ? 0 : (row == 1 ? y.inner : y.north);
  Room room;
  room.area = {x0, y0, x0 + options.room_width_m, y0 + options.room_depth_m};
  const bool opens_to_south_corridor = row == 1 && column % 2 == 0;
  room.inward = {0, row == 2 || opens_to_south_corridor ? 1.0 : -1.0};
  room.door_x_m = kDoorPosition * options.room_width_m;
  room.style = StyleOfRoom(options, room_idx, num_columns);
  return room;
}

Rect2 Doorway(const BuildingOptions& options, const Room& room) {
  const double half = options.door_width_m / 2;
  const Eigen::Vector2d a = room.ToBuilding({room.door_x_m - half, -options.wall_thickness_m});
  const Eigen::Vector2d b = room.ToBuilding({room.door_x_m + half, 0});
  return {std::min(a.x(), b.x()),
          std::min(a.y(), b.y()),
          std::max(a.x(), b.x()),
          std::max(a.y(), b.y())};
}

// The stretch lies in the middle of the east corridor, between its corners.
Rect2 BlankStretch(const BuildingOptions& options, const Rect2& east) {
  const double length_m = options.blank_walls_length_m;
  if (length_m <= 0) return {};
  if (length_m > options.room_depth_m) {
    throw UsageError("blank_walls_length_m = {} is longer than room_depth_m = {}: raise that",
                     length_m,
                     options.room_depth_m);
  }
  const double middle_y = (east.y0 + east.y1) / 2;
  return {east.x0, middle_y - length_m / 2, east.x1, middle_y + length_m / 2};
}

}  // namespace

Eigen::Vector2d Room::ToBuilding(const Eigen::Vector2d& point_in_room) const {
  if (inward.y() > 0) return {area.x0 + point_in_room.x(), area.y0 + point_in_room.y()};
  return {area.x1 - point_in_room.x(), area.y1 - point_in_room.y()};
}

double Room::Yaw_rad() const { return inward.y() > 0 ? 0 : std::numbers::pi; }

bool FloorLayout::IsIndoors(double x, double y) const {
  const auto contains = [x, y](const Rect2& rect) { return rect.Contains(x, y); };
  return std::any_of(corridor.begin(), corridor.end(), contains) ||
         std::any_of(doorways.begin(), doorways.end(), contains) ||
         (ramp_hall && ramp_hall->passage.Contains(x, y)) ||
         std::any_of(rooms.begin(), rooms.end(), [&](const Room& r) { return contains(r.area); });
}

double FloorLayout::IndoorArea_m2() const {
  double area_m2 = 0;
  for (const Room& room : rooms) area_m2 += room.area.Area();
  for (const Rect2& doorway : doorways) area_m2 += doorway.Area();
  const double half_width = center_line.x0 - corridor[3].x0;
  const double outer = (corridor[1].x1 - corridor[3].x0) * (corridor[2].y1 - corridor[0].y0);
  const double inner = (center_line.x1 - center_line.x0 - 2 * half_width) *
                       (center_line.y1 - center_line.y0 - 2 * half_width);
  return area_m2 + outer - inner;
}

FloorLayout PlanLayout(const BuildingOptions& options) {
  const RowHeights y = ComputeRowHeights(options);
  const double wall = options.wall_thickness_m;
  const double width = options.corridor_width_m;
  FloorLayout layout;
  layout.num_columns = (options.num_rooms + kNumRoomRows - 1) / kNumRoomRows;
  for (int room_idx = 0; room_idx < options.num_rooms; ++room_idx) {
    layout.rooms.push_back(MakeRoom(options, y, room_idx, layout.num_columns));
    layout.doorways.push_back(Doorway(options, layout.rooms.back()));
  }
  const double x1 = 2 * width + wall + layout.num_columns * (options.room_width_m + wall);
  const double y0 = y.south_corridor;
  const double y1 = y.north_corridor + width;
  layout.corridor = {{0, y0, x1, y0 + width},
                     {x1 - width, y0, x1, y1},
                     {0, y1 - width, x1, y1},
                     {0, y0, width, y1}};
  layout.blank = BlankStretch(options, layout.corridor[1]);
  layout.center_line = {width / 2, y0 + width / 2, x1 - width / 2, y1 - width / 2};
  layout.extent = {-wall, -wall, x1 + wall, y.north + options.room_depth_m + wall};
  layout.num_floors = options.num_floors;
  layout.storey_m = options.ceiling_height_m + options.slab_thickness_m;
  if (options.num_floors > 1) {
    layout.ramp_hall = PlanRampHall(options, layout.corridor[3], layout.extent);
  }
  return layout;
}

}  // namespace nightmap
