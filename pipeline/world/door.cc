// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "pipeline/base/random.h"
#include "pipeline/world/furniture.h"
#include "pipeline/world/shell.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kDoorStream = 1101;

}  // namespace

void BuildDoor(const Room& room, const BuildingOptions& options, SceneBuilder& builder) {
  Random random(static_cast<std::uint64_t>(options.seed), kDoorStream);
  const Material wood = builder.Tiled(Paint::kWood, random);
  const Material metal = builder.Plain({0.4F, 0.4F, 0.42F});
  Piece door({room.ToBuilding({0, 0}), room.Yaw_rad()}, builder);
  const double x0 = room.door_x_m - options.door_width_m / 2;
  const double x1 = room.door_x_m + options.door_width_m / 2;
  constexpr double kTrim_m = 0.07;
  for (const double y : {0.0, -options.wall_thickness_m - 0.02}) {
    door.Add({x0 - kTrim_m, y, 0}, {x0, y + 0.02, kDoorHeight_m}, SurfaceLabel::kDoor, wood);
    door.Add({x1, y, 0}, {x1 + kTrim_m, y + 0.02, kDoorHeight_m}, SurfaceLabel::kDoor, wood);
    door.Add({x0 - kTrim_m, y, kDoorHeight_m},
             {x1 + kTrim_m, y + 0.02, kDoorHeight_m + kTrim_m},
             SurfaceLabel::kDoor,
             wood);
  }
  constexpr double kOpen_rad = 1.85;
  const double length = options.door_width_m - 0.03;
  const Eigen::Vector2d along(std::cos(kOpen_rad), std::sin(kOpen_rad));
  const Eigen::Vector2d middle = Eigen::Vector2d(x0 - 0.02, 0.06) + along * length / 2;
  const Eigen::Vector3d half(length / 2, 0.02, (kDoorHeight_m - 0.02) / 2);
  const Eigen::Vector3d center(middle.x(), middle.y(), 0.01 + half.z());
  const Material notice = builder.Picture(Paint::kPanel, static_cast<std::uint64_t>(options.seed));
  door.Add(center - half, center + half, SurfaceLabel::kDoor, wood, kOpen_rad);
  const Eigen::Vector2d knob = Eigen::Vector2d(x0 - 0.02, 0.06) + along * (length - 0.07);
  const Eigen::Vector3d knob_center(knob.x(), knob.y(), 1.0);
  const Eigen::Vector3d knob_half(0.05, 0.05, 0.015);
  door.Add(knob_center - knob_half, knob_center + knob_half, SurfaceLabel::kDoor, metal, kOpen_rad);
  const Eigen::Vector3d sign_half(0.2, 0.026, 0.2);
  const Eigen::Vector3d sign_center(middle.x(), middle.y(), 1.45);
  door.Add(sign_center - sign_half,
           sign_center + sign_half,
           SurfaceLabel::kDoor,
           wood,
           kOpen_rad,
           &notice);
  door.Commit();
}

}  // namespace nightmap
