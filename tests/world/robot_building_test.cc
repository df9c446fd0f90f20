// SPDX-License-Identifier: Apache-2.0
// Parts of the building for a robot: the blank stretch of the corridor, and fittings of ceilings.
#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/world/fit_ceiling.h"
#include "pipeline/world/render.h"
#include "pipeline/world/route.h"

namespace nightmap::robot_building_test {

BuildingOptions LongCorridor(double blank_walls_length_m) {
  BuildingOptions options;
  options.num_rooms = 3;
  options.room_depth_m = 6;
  options.light_map_cell_m = 0.3;
  options.num_light_samples = 8;
  options.blank_walls_length_m = blank_walls_length_m;
  return options;
}

// Largest difference of neighbouring pixels, in levels, where both show the same wall or the same
// floor; from the middle of the east corridor.
int LargestStep(const BuildingOptions& options, double heading_rad) {
  const SyntheticWorld world = BuildWorld(options, RouteOptions{}, 2);
  SyntheticCameraOptions camera;
  camera.image_width_px = 80;
  camera.image_height_px = 60;
  camera.focal_length_px = 65;
  const Rect2& line = world.layout.center_line;
  const RoutePoint point{{line.x1, (line.y0 + line.y1) / 2}, heading_rad, 0};
  const Rigid3 pose = CameraPose(point, 1.0, 0.3);
  const RenderedFrame frame = Render(world, camera.Pinhole(), pose, DepthSensorOptions{}, 0, 1);
  int largest = 0;
  for (int y = 0; y < frame.labels.height; ++y) {
    for (int x = 2; x + 1 < frame.labels.width; ++x) {
      const auto label = static_cast<SurfaceLabel>(frame.labels.At(x, y));
      const std::int32_t surface = frame.surface_idx.At(x, y);
      const bool is_shell = label == SurfaceLabel::kWall || label == SurfaceLabel::kFloor;
      // Pixels at the border of a surface are mixed with the next.
      const bool is_inside = surface == frame.surface_idx.At(x - 1, y) &&
                             surface == frame.surface_idx.At(x - 2, y) &&
                             surface == frame.surface_idx.At(x + 1, y);
      if (!is_shell || !is_inside || (y > 0 && surface != frame.surface_idx.At(x, y - 1))) continue;
      const std::size_t at = static_cast<std::size_t>(y * frame.labels.width + x);
      const int step = frame.color.pixels[3 * at] - frame.color.pixels[3 * (at - 1)];
      largest = std::max(largest, std::abs(step));
    }
  }
  return largest;
}

TEST(BlankCorridor, WallsAndFloorHaveOneColor) {
  for (const double heading_rad : {0.0, 3.1416}) {
    EXPECT_LE(LargestStep(LongCorridor(6), heading_rad), 0) << heading_rad;
    EXPECT_GT(LargestStep(LongCorridor(0), heading_rad), 6) << heading_rad;
  }
}

TEST(BlankCorridor, NothingStandsOrHangsThere) {
  const auto count = [](double blank_walls_length_m) {
    const SyntheticWorld world = BuildWorld(LongCorridor(blank_walls_length_m), RouteOptions{}, 2);
    const Rect2 blank = PlanLayout(LongCorridor(6)).blank;
    return std::ranges::count_if(world.scene.boxes, [&](const Box& box) {
      return box.label != SurfaceLabel::kWall && blank.Contains(box.center.x(), box.center.y());
    });
  };
  EXPECT_EQ(count(6), 0);
  EXPECT_GT(count(0), 0);
}

TEST(BlankCorridor, IsAsLongAsItsOption) {
  const FloorLayout layout = PlanLayout(LongCorridor(5));
  EXPECT_NEAR(layout.blank.y1 - layout.blank.y0, 5, 1e-9);
  EXPECT_EQ(layout.blank.x1, layout.corridor[1].x1);
  EXPECT_EQ(PlanLayout(LongCorridor(0)).blank.Area(), 0);
  EXPECT_THROW(PlanLayout(LongCorridor(6.1)), UsageError);
}

TEST(FitCeiling, FittingsLieApartBelowTheCeiling) {
  constexpr double kCeiling_m = 2.6;
  const Rect2 rect{1, 2, 7, 5};
  SceneBuilder builder(3);
  builder.AddLamp({{2.5, 3.5, kCeiling_m}, {0.3, 0.3}, 1});
  FitCeiling(rect, kCeiling_m, 1.0, Random(3), builder);
  const std::vector<Surface> surfaces = builder.Finish(1).surfaces;
  const auto low = [](const Surface& s) { return Eigen::Vector2d(s.origin.head<2>()); };
  const auto high = [](const Surface& s) {
    return Eigen::Vector2d((s.origin + s.edge_u + s.edge_v).head<2>());
  };
  std::vector<Surface> bases;  // the lamp, and the upper layer of each fitting
  for (const Surface& surface : surfaces) {
    EXPECT_LT(surface.origin.z(), kCeiling_m);
    EXPECT_GT(surface.origin.z(), kCeiling_m - 0.02);
    EXPECT_GE(low(surface).x(), rect.x0);
    EXPECT_LE(high(surface).y(), rect.y1);
    EXPECT_LT(surface.Normal().z(), -0.99);
    if (surface.origin.z() > kCeiling_m - 0.006) bases.push_back(surface);
  }
  EXPECT_GE(bases.size(), 10U);
  for (std::size_t i = 0; i < bases.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool is_apart = (low(bases[i]).array() > high(bases[j]).array()).any() ||
                            (low(bases[j]).array() > high(bases[i]).array()).any();
      EXPECT_TRUE(is_apart) << i << ' ' << j;
    }
  }
}

TEST(FitCeiling, NoneAreFittedByDefault) {
  SceneBuilder builder(3);
  FitCeiling({0, 0, 5, 5}, 2.6, BuildingOptions{}.ceiling_fittings_per_m2, Random(3), builder);
  EXPECT_TRUE(builder.Finish(1).surfaces.empty());
}

}  // namespace nightmap::robot_building_test
