// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/route_keys.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace nightmap {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kTurnReach_m = 0.7;  // a turn begins this far before a corner or a door
// At a corner the camera turns farther than the corridor does, and back. So it sees the inner wall
// of the next corridor, which it would otherwise pass before that comes into view.
constexpr double kCornerLook_deg = 40;

// A place on the ring where the robot turns: a corner (room_idx -1) or the door of a room.
struct Event {
  double arc_m = 0;
  int room_idx = -1;
};

// The rectangle the robot drives around, by arc length from the middle of its west side.
class Ring {
 public:
  Ring(const Rect2& center_line, double inset_m) {
    const double x0 = center_line.x0 + inset_m;
    const double y0 = center_line.y0 + inset_m;
    const double x1 = center_line.x1 - inset_m;
    const double y1 = center_line.y1 - inset_m;
    corners_ = {Eigen::Vector2d(x0, (y0 + y1) / 2), {x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      start_m_[i + 1] = start_m_[i] + (Corner(i + 1) - corners_[i]).norm();
    }
  }
  double Length_m() const { return start_m_.back(); }
  double CornerArc_m(std::size_t corner) const { return start_m_[corner]; }

  Eigen::Vector2d At(double arc_m) const {
    const std::size_t side = SideOf(arc_m);
    return corners_[side] + (arc_m - start_m_[side]) * Direction(side);
  }
  // Heading of the robot before the first corner is -90 degrees; each corner turns left.
  double Heading_rad(double arc_m) const {
    return (static_cast<double>(SideOf(arc_m)) - 1) * 90 * kDegree;
  }
  // Arc length of the point of side 1 (south) or 3 (north) with this x.
  double ArcAtX_m(std::size_t side, double x) const {
    return start_m_[side] + std::abs(x - corners_[side].x());
  }

 private:
  Eigen::Vector2d Corner(std::size_t i) const { return corners_[i % corners_.size()]; }
  Eigen::Vector2d Direction(std::size_t side) const {
    return (Corner(side + 1) - corners_[side]).normalized();
  }
  std::size_t SideOf(double arc_m) const {
    std::size_t side = 0;
    while (side + 1 < corners_.size() && arc_m > start_m_[side + 1]) ++side;
    return side;
  }

  std::array<Eigen::Vector2d, 5> corners_;
  std::array<double, 6> start_m_{};
};

std::vector<Event> ListEvents(const FloorLayout& layout, const Ring& ring) {
  std::vector<Event> events;
  for (std::size_t corner = 1; corner <= 4; ++corner)
    events.push_back({ring.CornerArc_m(corner), -1});
  const double middle_y = (layout.center_line.y0 + layout.center_line.y1) / 2;
  for (std::size_t i = 0; i < layout.rooms.size(); ++i) {
    const Eigen::Vector2d door = layout.rooms[i].ToBuilding({layout.rooms[i].door_x_m, 0});
    const std::size_t side = door.y() < middle_y ? 1 : 3;
    events.push_back({ring.ArcAtX_m(side, door.x()), static_cast<int>(i)});
  }
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) {
    return a.arc_m < b.arc_m;
  });
  return events;
}

// Keys of one visit: through the door, around the free middle of the room, and out. The camera
// turns once around towards the side of the room, so that it looks across the room all the time.
void AppendVisit(const Room& room,
                 const Eigen::Vector2d& ring_point,
                 double heading_rad,
                 double loop_scale,
                 std::vector<RoutePoint>& keys) {
  const bool is_left = std::sin(heading_rad - std::atan2(room.inward.y(), room.inward.x())) < 0;
  const double sign = is_left ? 1 : -1;
  const auto add = [&](const Eigen::Vector2d& position, double turn_deg) {
    keys.push_back({position, heading_rad + sign * turn_deg * kDegree});
  };
  const Eigen::Vector2d door = room.ToBuilding({room.door_x_m, 0});
  const Eigen::Vector2d inside = room.ToBuilding({room.door_x_m, 0.4});
  add(ring_point, 28);
  add(door, 52);
  add(inside, 66);
  constexpr int kNumLoopPoints = 9;
  const Eigen::Vector2d middle(room.Width_m() / 2, 0.47 * room.Depth_m());
  const Eigen::Vector2d radii(std::max(0.3, loop_scale * (room.Width_m() / 2 - 1.15)),
                              std::max(0.3, loop_scale * (0.47 * room.Depth_m() - 1.0)));
  for (int i = 0; i < kNumLoopPoints; ++i) {
    const double fraction = static_cast<double>(i) / (kNumLoopPoints - 1);
    const double angle_rad = (-80 + 250 * fraction) * kDegree;
    const Eigen::Vector2d offset(sign * std::cos(angle_rad) * radii.x(),
                                 std::sin(angle_rad) * radii.y());
    add(room.ToBuilding(middle + offset), 75 + 208 * fraction);
  }
  add(inside, 294);
  add(door, 308);
  add(ring_point, 332);
}

double NetTurn_rad(const std::vector<RoutePoint>& keys, double heading_rad) {
  return std::round((keys.back().heading_rad - heading_rad) / (360 * kDegree)) * 360 * kDegree;
}

// One lap; `turned_rad` counts whole turns of the heading so far.
void AppendLap(const FloorLayout& layout,
               const Ring& ring,
               double loop_scale,
               double floor_m,
               double& turned_rad,
               std::vector<RoutePoint>& keys) {
  const std::vector<Event> events = ListEvents(layout, ring);
  const std::size_t first = keys.size();
  const auto add = [&](double arc_m, double heading_rad) {
    keys.push_back({ring.At(arc_m), heading_rad + turned_rad});
  };
  add(0, -90 * kDegree);
  for (std::size_t i = 0; i < events.size(); ++i) {
    const double arc_m = events[i].arc_m;
    const double before_m = arc_m - (i > 0 ? events[i - 1].arc_m : 0);
    const double after_m = (i + 1 < events.size() ? events[i + 1].arc_m : ring.Length_m()) - arc_m;
    const double heading_rad = ring.Heading_rad(arc_m);
    const double before_reach_m = std::min(kTurnReach_m, before_m / 2);
    const double after_reach_m = std::min(kTurnReach_m, after_m / 2);
    add(arc_m - before_reach_m, heading_rad);
    if (events[i].room_idx < 0) {
      add(arc_m, heading_rad + 60 * kDegree);
      add(arc_m + 0.6 * after_reach_m, heading_rad + (90 + kCornerLook_deg) * kDegree);
      add(arc_m + after_reach_m, heading_rad + 90 * kDegree);
      continue;
    }
    const Room& room = layout.rooms[static_cast<std::size_t>(events[i].room_idx)];
    AppendVisit(room, ring.At(arc_m), heading_rad + turned_rad, loop_scale, keys);
    turned_rad += NetTurn_rad(keys, heading_rad + turned_rad);
    add(arc_m + after_reach_m, heading_rad);
  }
  turned_rad += 360 * kDegree;  // the ring itself
  for (std::size_t i = first; i < keys.size(); ++i) keys[i].floor_m = floor_m;
}

// Keys over the ramp: leaves the west corridor southwards and enters it southwards on the other
// floor.
void AppendRamp(const RampHall& hall,
                bool is_upwards,
                double& turned_rad,
                std::vector<RoutePoint>& keys) {
  const auto middle = [](double a, double b) { return (a + b) / 2; };
  const double west_x = middle(hall.up.x0, hall.up.x1);
  const double east_x = middle(hall.down.x0, hall.down.x1);
  const double landing_y = middle(hall.landing.y0, hall.landing.y1);
  const double half_y = middle(hall.half_landing.y0, hall.half_landing.y1);
  const Eigen::Vector2d passage(middle(hall.passage.x0, hall.passage.x1), landing_y);
  const double start_rad = turned_rad;
  const auto add = [&](double x, double y, double storeys, double heading_deg) {
    keys.push_back({{x, y}, start_rad + heading_deg * kDegree, storeys * hall.storey_m});
  };
  if (is_upwards) {
    add(passage.x(), passage.y(), 0, -155);
    add(east_x, landing_y, 0, -180);
    add(west_x, landing_y, 0, -225);
    add(west_x, hall.up.y0, 0, -270);
    add(west_x, hall.up.y1, 0.5, -270);
    add(west_x, half_y, 0.5, -315);
    add(east_x, half_y, 0.5, -405);
    add(east_x, hall.down.y1, 0.5, -450);
    add(east_x, hall.down.y0, 1, -450);
    add(east_x, landing_y, 1, -400);
    add(passage.x(), passage.y(), 1, -385);
    turned_rad -= 360 * kDegree;
    return;
  }
  add(passage.x(), passage.y(), 1, -155);
  add(east_x, landing_y, 1, -200);
  add(east_x, hall.down.y0, 1, -270);
  add(east_x, hall.down.y1, 0.5, -270);
  add(east_x, half_y, 0.5, -225);
  add(west_x, half_y, 0.5, -135);
  add(west_x, hall.up.y1, 0.5, -90);
  add(west_x, hall.up.y0, 0, -90);
  add(west_x, landing_y, 0, -45);
  add(east_x, landing_y, 0, 0);
  add(passage.x(), passage.y(), 0, -20);
}

}  // namespace

std::vector<RoutePoint> RouteKeys(const FloorLayout& layout, const RouteOptions& options) {
  std::vector<RoutePoint> keys;
  double turned_rad = 0;
  for (int floor = 0; floor < layout.num_floors; ++floor) {
    for (int lap = 0; lap < options.num_laps; ++lap) {
      const double inset_m = lap % 2 == 0 ? 0 : 0.12;
      const double loop_scale = lap % 2 == 0 ? 1 : 0.8;
      const Ring ring(layout.center_line, inset_m);
      AppendLap(layout, ring, loop_scale, floor * layout.storey_m, turned_rad, keys);
    }
    if (!layout.ramp_hall) continue;
    const Ring ring(layout.center_line, 0);
    keys.push_back({ring.At(0), turned_rad - 90 * kDegree, floor * layout.storey_m});
    AppendRamp(*layout.ramp_hall, floor == 0, turned_rad, keys);
  }
  keys.push_back({keys.front().position, keys.front().heading_rad + turned_rad});
  return keys;
}

}  // namespace nightmap
