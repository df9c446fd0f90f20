// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/ramp_hall.h"

#include <numbers>

#include "pipeline/world/furniture.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kHallStream = 103;

// Level or sloping along y: `z0` at the southern edge, `z1` at the northern.
void AddGround(
    const Rect2& rect, double z0, double z1, const Material& material, SceneBuilder& builder) {
  Surface ground;
  ground.origin = {rect.x0, rect.y1, z1};
  ground.edge_u = {rect.x1 - rect.x0, 0, 0};
  ground.edge_v = {0, rect.y0 - rect.y1, z0 - z1};
  ground.label = SurfaceLabel::kFloor;
  ground.material = material;
  builder.AddSurface(ground);
}

void AddHallCeiling(const Rect2& rect, double z, const Material& material, SceneBuilder& builder) {
  Surface ceiling;
  ceiling.origin = {rect.x0, rect.y0, z};
  ceiling.edge_u = {rect.x1 - rect.x0, 0, 0};
  ceiling.edge_v = {0, rect.y1 - rect.y0, 0};
  ceiling.label = SurfaceLabel::kCeiling;
  ceiling.material = material;
  builder.AddSurface(ceiling);
}

class HallBuilder {
 public:
  HallBuilder(const RampHall& hall, const BuildingOptions& options, SceneBuilder& builder)
      : hall_(hall),
        wall_m_(options.wall_thickness_m),
        ceiling_m_(options.ceiling_height_m),
        top_m_(hall.storey_m + options.ceiling_height_m),
        random_(static_cast<std::uint64_t>(options.seed), kHallStream),
        builder_(builder) {}

  void AddWalls(const Rect2& corridor) {
    const Rect2& landing = hall_.landing;
    const double north = hall_.half_landing.y1;
    const double x0 = landing.x0 - wall_m_;
    const double x1 = landing.x1 + wall_m_;
    AddWall({x0, landing.y0 - wall_m_, landing.x0, north + wall_m_}, 0, top_m_);
    AddWall({landing.x0, landing.y0 - wall_m_, landing.x1, landing.y0}, 0, top_m_);
    AddWall({landing.x0, north, landing.x1, north + wall_m_}, 0, top_m_);
    AddWall({landing.x1, corridor.y1, x1, north + wall_m_}, 0, top_m_);
    AddWall({landing.x1, corridor.y0, x1, corridor.y1}, ceiling_m_, hall_.storey_m);  // the slab
    AddWall({hall_.up.x1, hall_.up.y0, hall_.down.x0, hall_.up.y1}, 0, top_m_);
    // Fills the space under the upper end of the ramp, and above the lower end.
    const double slope = hall_.storey_m / 2 / (hall_.down.y1 - hall_.down.y0);
    AddWall({hall_.down.x0, landing.y1, hall_.down.x1, landing.y1 + wall_m_},
            0,
            hall_.storey_m - slope * wall_m_ - 0.02);
    AddWall({hall_.up.x0, landing.y1, hall_.up.x1, landing.y1 + wall_m_}, ceiling_m_, top_m_);
  }

  void AddGrounds() {
    const Material floor = builder_.Tiled(Paint::kTerrazzo, random_);
    const Material ramp = builder_.Tiled(Paint::kPlanks, random_);
    const Material ceiling = builder_.Tiled(Paint::kCeiling, random_);
    const double half_m = hall_.storey_m / 2;
    for (const double z : {0.0, hall_.storey_m}) {
      AddGround(hall_.landing, z, z, floor, builder_);
      AddGround(hall_.passage, z, z, floor, builder_);
    }
    AddGround(hall_.up, 0, half_m, ramp, builder_);
    AddGround(hall_.half_landing, half_m, half_m, floor, builder_);
    AddGround(hall_.down, hall_.storey_m, half_m, ramp, builder_);
    AddHallCeiling(hall_.landing, ceiling_m_, ceiling, builder_);
    const Rect2 all{hall_.landing.x0, hall_.landing.y0, hall_.landing.x1, hall_.half_landing.y1};
    AddHallCeiling(all, top_m_, ceiling, builder_);
    for (const double y : {0.1, 0.35, 0.6, 0.85}) {
      for (const double x : {0.25, 0.75}) {
        builder_.AddLamp({{all.x0 + x * (all.x1 - all.x0), all.y0 + y * (all.y1 - all.y0), top_m_},
                          {0.3, 0.3},
                          2});
      }
    }
    const Rect2& landing = hall_.landing;
    builder_.AddLamp({{(landing.x0 + landing.x1) / 2, (landing.y0 + landing.y1) / 2, ceiling_m_},
                      {0.3, 0.3},
                      3});
  }

  void HangPosters() {
    constexpr double kRight_rad = std::numbers::pi / 2;
    const Rect2& landing = hall_.landing;
    const Rect2& half = hall_.half_landing;
    const double length_m = half.y1 - landing.y0;
    const double lane_m = hall_.up.y1 - hall_.up.y0;
    HangPostersOn({{landing.x0, half.y1}, -kRight_rad}, length_m);
    HangPostersOn({{hall_.up.x1, hall_.up.y0}, kRight_rad}, lane_m);
    HangPostersOn({{hall_.down.x0, hall_.down.y1}, -kRight_rad}, lane_m);
    HangPostersOn({{landing.x1, landing.y1}, kRight_rad}, half.y1 - landing.y1);
    HangPostersOn({{half.x1, half.y1}, 2 * kRight_rad}, half.x1 - half.x0);
    HangPostersOn({{landing.x0, landing.y0}, 0}, landing.x1 - landing.x0);
  }

 private:
  void AddWall(const Rect2& rect, double z0, double z1) {
    Box box;
    box.center = {(rect.x0 + rect.x1) / 2, (rect.y0 + rect.y1) / 2, (z0 + z1) / 2};
    box.half_size = {(rect.x1 - rect.x0) / 2, (rect.y1 - rect.y0) / 2, (z1 - z0) / 2};
    box.label = SurfaceLabel::kWall;
    builder_.AddBox(box, builder_.Tiled(Paint::kWallpaper, random_));
  }

  // Hangs rows of posters up the whole wall, because the camera passes at every height.
  void HangPostersOn(const Placement& wall, double length_m) {
    const Material frame = builder_.Plain({0.3F, 0.25F, 0.2F});
    for (double z = 0.7; z + 0.8 < top_m_; z += 1.0) {
      for (double x = random_.Uniform(0.1, 0.4); x + 0.7 < length_m;
           x += random_.Uniform(0.8, 1.3)) {
        const double width_m = random_.Uniform(0.4, 0.65);
        const double height_m = random_.Uniform(0.45, 0.75);
        const Material picture = builder_.Picture(Paint::kPoster, random_.Next());
        Piece poster(wall, builder_);
        poster.Add({x, 0, z},
                   {x + width_m, 0.015, z + height_m},
                   SurfaceLabel::kPoster,
                   frame,
                   0,
                   &picture);
        poster.Commit();
      }
    }
  }

  const RampHall& hall_;
  double wall_m_, ceiling_m_, top_m_;
  Random random_;
  SceneBuilder& builder_;
};

}  // namespace

std::optional<double> RampHall::RampHeight_m(double x, double y) const {
  const double half_m = storey_m / 2;
  const double along = (y - up.y0) / (up.y1 - up.y0);
  if (half_landing.Contains(x, y)) return half_m;
  if (up.Contains(x, y)) return along * half_m;
  if (down.Contains(x, y)) return storey_m - along * half_m;
  return {};
}

RampHall PlanRampHall(const BuildingOptions& options, const Rect2& corridor, const Rect2& extent) {
  const double width = options.corridor_width_m;
  const double middle_y = (corridor.y0 + corridor.y1) / 2;
  RampHall hall;
  hall.storey_m = options.ceiling_height_m + options.slab_thickness_m;
  const double lane_m = hall.storey_m / 2 / options.ramp_slope;
  const double x1 = extent.x0;
  const double x0 = x1 - 2 * width - options.wall_thickness_m;
  const double y0 = middle_y - width / 2;
  const double y1 = y0 + width;
  hall.landing = {x0, y0, x1, y1};
  hall.up = {x0, y1, x0 + width, y1 + lane_m};
  hall.down = {x1 - width, y1, x1, y1 + lane_m};
  hall.half_landing = {x0, y1 + lane_m, x1, y1 + lane_m + width};
  constexpr double kJamb_m =
      0.05;  // the passage is nearly as wide as a lane, because the route turns in it
  hall.passage = {x1, y0 + kJamb_m, corridor.x0, y1 - kJamb_m};
  return hall;
}

void BuildRampHall(const RampHall& hall,
                   const BuildingOptions& options,
                   const Rect2& corridor,
                   SceneBuilder& builder) {
  HallBuilder hall_builder(hall, options, builder);
  hall_builder.AddWalls(corridor);
  hall_builder.AddGrounds();
  hall_builder.HangPosters();
}

}  // namespace nightmap
