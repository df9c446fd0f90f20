// SPDX-License-Identifier: Apache-2.0
// Where rooms, corridor and doors are: a rectangular corridor loop with one row of rooms inside it
// and a row outside its south and its north side.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/synthetic/scene.h"
#include "pipeline/synthetic/synthetic_options.h"

namespace nightmap {

// A room has a frame of its own: origin at the left end of its door wall seen from the corridor,
// x along the door wall, y into the room. Furniture is placed in it, so identical rooms are equal.
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
  std::vector<Rect2> doorways;  // one a room: the gap in the wall
  Rect2 center_line;            // rectangle through the middle of the corridor
  Rect2 extent;                 // of everything, outer walls included
  int num_columns = 0;

  // Free of walls: a room, the corridor or a doorway.
  bool IsIndoors(double x, double y) const;
  double IndoorArea_m2() const;
};

FloorLayout PlanLayout(const BuildingOptions& options);

}  // namespace nightmap
