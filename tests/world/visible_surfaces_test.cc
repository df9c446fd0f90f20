// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/visible_surfaces.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "pipeline/world/ray_scene.h"
#include "pipeline/world/route.h"

namespace nightmap::visible_surfaces_test {

constexpr Camera kCamera{.width = 150, .height = 100, .fx = 90, .fy = 95, .cx = 71, .cy = 48};

// Boxes around the origin at random, inside a large one.
std::vector<Surface> RandomBoxes(int num_boxes, std::uint64_t seed) {
  Random random(seed);
  std::vector<Surface> surfaces;
  const auto add = [&](const Box& box) {
    for (const Surface& face : BoxFaces(box, Material{})) surfaces.push_back(face);
  };
  add({{0, 0, 0}, {9, 9, 4}});
  for (int i = 0; i < num_boxes; ++i) {
    Box box;
    box.center = {random.Uniform(1.5, 8), random.Uniform(-5, 5), random.Uniform(-3, 3)};
    for (int c = 0; c < 3; ++c) box.half_size[c] = random.Uniform(0.01, 0.6);
    box.yaw_rad = random.Uniform(-3, 3);
    add(box);
  }
  return surfaces;
}

// Compares with rays at points between and beside the pixels; returns the share that At decides.
double CompareWithRays(const std::vector<Surface>& surfaces, const Rigid3& pose) {
  const RayScene rays(surfaces);
  const VisibleSurfaces visible(surfaces, kCamera, pose);
  int num_decided = 0;
  int num_points = 0;
  for (double y = -0.45; y < kCamera.height - 0.5; y += 0.31) {
    for (double x = -0.45; x < kCamera.width - 0.5; x += 0.31) {
      ++num_points;
      const auto surface_idx = visible.At(x, y);
      if (!surface_idx) continue;
      ++num_decided;
      const Eigen::Vector3d direction = pose.rotation * kCamera.BackProject({x, y}, 1);
      EXPECT_EQ(*surface_idx, rays.Cast(pose.translation, direction).surface_idx)
          << "at " << x << ", " << y;
    }
  }
  return static_cast<double>(num_decided) / num_points;
}

TEST(VisibleSurfaces, SeesWhatRaysHitAndDecidesNearlyEverywhere) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Rigid3 pose = CameraPose({{0.1, -0.2}, 0.2}, 0.3, 0.1 * static_cast<double>(seed));
    EXPECT_GT(CompareWithRays(RandomBoxes(40, seed), pose), 0.95);
  }
}

TEST(VisibleSurfaces, TheOrderOfSurfacesAtEqualDepthIsLeftToRays) {
  std::vector<Surface> surfaces = RandomBoxes(0, 1);
  const std::vector<Surface> copy = surfaces;
  surfaces.insert(surfaces.end(), copy.begin(), copy.end());
  EXPECT_EQ(CompareWithRays(surfaces, CameraPose({{0, 0}, 0}, 0, 0)), 0);
}

// The top of a box at the camera's height is a line; its plane holds the camera.
TEST(VisibleSurfaces, ASurfaceSeenEdgeOnHidesNothing) {
  std::vector<Surface> surfaces = RandomBoxes(0, 1);
  for (const Surface& face : BoxFaces({{3, 0, 0.5}, {0.5, 1, 0.5}}, Material{})) {
    surfaces.push_back(face);
  }
  EXPECT_GT(CompareWithRays(surfaces, CameraPose({{0, 0}, 0}, 1, 0)), 0.95);
}

TEST(VisibleSurfaces, DecidesNothingWhereNothingIsSeen) {
  const VisibleSurfaces visible({}, kCamera, Rigid3{});
  EXPECT_FALSE(visible.At(10, 10));
}

TEST(VisibleSurfaces, IgnoresWhatIsBehindTheCamera) {
  Surface wall;
  wall.origin = {-2, -5, -5};
  wall.edge_u = {0, 10, 0};
  wall.edge_v = {0, 0, 10};
  EXPECT_EQ(CompareWithRays({wall}, CameraPose({{0, 0}, 0}, 0, 0)), 0);
}

}  // namespace nightmap::visible_surfaces_test
