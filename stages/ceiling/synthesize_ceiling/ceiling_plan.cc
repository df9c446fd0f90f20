// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/ceiling_plan.h"

#include <cmath>
#include <numbers>

namespace nightmap {

namespace {

constexpr double kCorridorHeight_m = 2.6;
constexpr double kHallHeight_m = 3.1;
constexpr double kBeamWidth_m = 0.2;
constexpr double kBeamDrop_m = 0.2;
constexpr double kLintelHeight_m = 2.1;
constexpr double kLintelDepth_m = 0.15;
constexpr double kHalfWidth_m = 1;
constexpr double kFireDoor_m = 1.2;
constexpr double kDoor_m = 0.9;
constexpr double kMaxBlank_m = 12;

void AddRect(CeilingPlan& plan, const Rect2& area, double height_m, CeilingFinish finish) {
  plan.rects.push_back({area, height_m, finish, static_cast<int>(plan.rects.size())});
}

// Lays pieces of one straight corridor one behind the other, along x or along y.
class Strip {
 public:
  Strip(CeilingPlan& plan, bool is_along_x, double middle_m, double begin_m)
      : plan_(plan), is_along_x_(is_along_x), middle_m_(middle_m), at_m_(begin_m) {}

  Strip& To(double end_m, CeilingFinish finish, double height_m = kCorridorHeight_m) {
    return Piece(end_m, kHalfWidth_m, finish, height_m);
  }
  Strip& Beam(double ceiling_m = kCorridorHeight_m) {
    return Piece(
        at_m_ + kBeamWidth_m, kHalfWidth_m, CeilingFinish::kPaint, ceiling_m - kBeamDrop_m);
  }
  Strip& FireDoor() {
    return Piece(at_m_ + kLintelDepth_m, kFireDoor_m / 2, CeilingFinish::kPaint, kLintelHeight_m);
  }

 private:
  Strip& Piece(double end_m, double half_m, CeilingFinish finish, double height_m) {
    if (end_m > at_m_) {
      const Rect2 along{at_m_, middle_m_ - half_m, end_m, middle_m_ + half_m};
      const Rect2 across{along.y0, along.x0, along.y1, along.x1};
      AddRect(plan_, is_along_x_ ? along : across, height_m, finish);
    }
    at_m_ = end_m;
    return *this;
  }

  CeilingPlan& plan_;
  bool is_along_x_;
  double middle_m_;
  double at_m_;
};

void AddAllFittings(int seed, CeilingPlan& plan) {
  for (std::size_t i = 0; i < plan.rects.size(); ++i) AddFittings(static_cast<int>(i), seed, plan);
}

}  // namespace

int CeilingPlan::RectAt(double x, double y) const {
  for (std::size_t i = 0; i < rects.size(); ++i) {
    if (rects[i].area.Contains(x, y)) return static_cast<int>(i);
  }
  return -1;
}

bool CeilingPlan::IsFree(const Eigen::Vector2d& point, double clearance_m) const {
  constexpr int kDirections = 32;
  for (int i = 0; i < kDirections; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kDirections;
    const double x = point.x() + clearance_m * std::cos(angle_rad);
    const double y = point.y() + clearance_m * std::sin(angle_rad);
    if (RectAt(x, y) < 0) return false;
  }
  return true;
}

CeilingPlan PlanCeilingCorridor(double blank_length_m, double overlap_m, int seed) {
  using enum CeilingFinish;
  constexpr double kX = 40, kY = 20, kStart_m = 3, kBack_m = 5;
  CeilingPlan plan;
  Strip(plan, true, 0, -1)
      .To(9, kMineral)
      .Beam()
      .To(23.6, kRepeated)
      .FireDoor()
      .To(33, kPlaster)
      .Beam()
      .To(kX + 1, kMineral);
  const double blank_end_m = 5 + std::min(blank_length_m, kMaxBlank_m);
  Strip(plan, false, kX, 1).To(5, kPlaster).To(blank_end_m, kBlank).To(kY - 1, kPlaster);
  if (blank_length_m > 0) plan.blank = {kX - 1, 5, kX + 1, blank_end_m};
  Strip(plan, true, kY, -1)
      .To(10, kMineral)
      .Beam()
      .To(19, kPlaster)
      .To(29, kMineral, kHallHeight_m)
      .To(33, kMineral)
      .Beam()
      .To(37, kMineral)
      .Beam()
      .To(kX + 1, kPlaster);
  Strip(plan, false, 0, 1)
      .To(6, kPlaster)
      .FireDoor()
      .To(14.8, kMineral)
      .Beam()
      .To(kY - 1, kPlaster);
  AddAllFittings(seed, plan);
  const double end_m = kStart_m + overlap_m;
  plan.legs = {{{kStart_m, 0}, {kX, 0}, {kX, kY}, {0, kY}, {0, 0}, {end_m, 0}},
               {{end_m, 0}, {end_m - kBack_m, 0}}};
  return plan;
}

CeilingPlan PlanCeilingOffice(int seed) {
  using enum CeilingFinish;
  constexpr double kRoomWidth_m = 5, kRoomDepth_m = 4, kPitch_m = 5.25, kFirst_m = 0.2;
  constexpr double kLength_m = 16, kStart_m = 1, kInRoom_m = 2.9;
  constexpr CeilingFinish kFinishes[2][3] = {{kMineral, kPlaster, kMineral},
                                             {kPlaster, kRepeated, kMineral}};
  CeilingPlan plan;
  Strip(plan, true, 0, 0).To(8, kMineral).Beam().To(kLength_m, kRepeated);
  double last_x = kStart_m;
  CeilingLeg leg = {{kStart_m, 0}};
  int first_look = 0;
  for (int column = 0; column < 3; ++column) {
    for (int side = 0; side < 2; ++side) {
      const double x0 = kFirst_m + column * kPitch_m;
      const double door_x = x0 + (side == 0 ? 2.1 : 3.3);
      const double wall_y = kHalfWidth_m + kLintelDepth_m;
      const auto mirrored = [side](double xa, double ya, double xb, double yb) {
        return side == 0 ? Rect2{xa, ya, xb, yb} : Rect2{xa, -yb, xb, -ya};
      };
      AddRect(plan,
              mirrored(door_x - kDoor_m / 2, kHalfWidth_m, door_x + kDoor_m / 2, wall_y),
              kLintelHeight_m,
              kPaint);
      AddRect(plan,
              mirrored(x0, wall_y, x0 + kRoomWidth_m, wall_y + kRoomDepth_m),
              kCorridorHeight_m,
              kFinishes[side][column]);
      if (side == 0 && column == 0) first_look = plan.rects.back().look;
      if (side == 0 && column == 2) plan.rects.back().look = first_look;
      const double in_room_y = side == 0 ? kInRoom_m : -kInRoom_m;
      leg.push_back({door_x, 0});
      leg.push_back({door_x, in_room_y});
      plan.legs.push_back(leg);
      leg = {{door_x, in_room_y}, {door_x, 0}};
      last_x = door_x;
    }
  }
  leg.push_back({kStart_m, 0});
  plan.legs.push_back(leg);
  plan.legs.push_back({{kStart_m, 0}, {std::min(kStart_m + 2, last_x), 0}});
  AddAllFittings(seed, plan);
  return plan;
}

}  // namespace nightmap
