// SPDX-License-Identifier: Apache-2.0
// Layout of rooms, corridor and doors: a rectangular corridor loop with one row of rooms inside it
// and one row each outside its south and north side.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pipeline/world/ramp_hall.h"
#include "pipeline/world/scene.h"
#include "pipeline/world/synthetic_options.h"

namespace nightmap {

// A room has its own frame: origin at the left end of its door wall seen from the corridor, x along
// the door wall, y into the room. Furniture is placed in this frame, so identical rooms are equal.
struct Room {
  Rect2 area;
  Eigen::Vector2d inward = Eigen::Vector2d::UnitY();  // from the door into the room: (0, +-1)
  double door_x_m = 0;                                // middle of the doorway, in the room frame
  int style = 0;                                      // rooms of equal style are furnished alike

  Eigen::Vector2d ToBuilding(const Eigen::Vector2d& point_in_room) const;
  double Yaw_rad() const;  // building_from_room
  double Width_m() const { return area.x1 - area.x0; }
  double Depth_m() const { return area.y1 - area.y0; }
};

struct FloorLayout {
  std::vector<Room> rooms;      // in the order of columns; within a column south, inner, north
  std::vector<Rect2> corridor;  // south, east, north, west; they overlap at the corners
  std::vector<Rect2> doorways;  // one per room: the gap in the wall
  Rect2 blank;                  // stretch of the east corridor of one color; empty: none
  Rect2 center_line;            // rectangle through the middle of the corridor
  Rect2 extent;                 // of everything but the ramp; includes outer walls
  int num_columns = 0;
  int num_floors = 1;
  double storey_m = 0;                // from one floor to the next
  std::optional<RampHall> ramp_hall;  // only in a building with two floors

  // Whether a point is free of walls on every floor: in a room, the corridor, a doorway or a
  // passage to the ramp.
  bool IsIndoors(double x, double y) const;
  double IndoorArea_m2() const;
};

// Throws UsageError when the blank stretch is longer than its corridor.
FloorLayout PlanLayout(const BuildingOptions& options);

}  // namespace nightmap
