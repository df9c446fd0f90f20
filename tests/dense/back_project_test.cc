// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/back_project.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/dense/rgbd_keyframes.h"

namespace nightmap::back_project_test {

RgbdCamera TestCamera() {
  RgbdCamera camera;
  camera.color = {64, 48, 60, 60, 31.5, 23.5, 0, 0, 0, 0, 0};
  return camera;
}

DepthImage Flat(float depth_m) { return {64, 48, 1, std::vector<float>(64 * 48, depth_m)}; }
ColorImage Black() { return {64, 48, 3, std::vector<std::uint8_t>(64 * 48 * 3, 0)}; }

std::vector<DepthPoint> BackProject(const DepthImage& depth, const DepthFilterOptions& options) {
  const RgbdCamera camera = TestCamera();
  return BackProjectDepth(depth, Black(), MakeRayTable(camera.color, 1), camera, 5.0, options);
}

DepthFilterOptions EveryPixel() {
  DepthFilterOptions options;
  options.pixel_stride = 1;
  return options;
}

TEST(BackProject, FlatWallKeepsEveryPixelAtItsDepth) {
  const auto points = BackProject(Flat(2.0F), EveryPixel());
  ASSERT_EQ(points.size(), 64U * 48U);
  for (const auto& point : points) EXPECT_FLOAT_EQ(point.point_in_camera.z(), 2.0F);
}

TEST(BackProject, StrideTakesEveryNthPixel) {
  DepthFilterOptions options;
  options.pixel_stride = 4;
  EXPECT_EQ(BackProject(Flat(2.0F), options).size(), 16U * 12U);
}

TEST(BackProject, HolesAndFarDepthGiveNoPoints) {
  EXPECT_TRUE(BackProject(Flat(0.0F), EveryPixel()).empty());
  EXPECT_TRUE(BackProject(Flat(5.1F), EveryPixel()).empty());
}

TEST(BackProject, FlyingPixelsBetweenTwoSurfacesAreDropped) {
  DepthImage depth = Flat(3.0F);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 30; ++x) depth.At(x, y) = 1.5F;
    depth.At(30, y) = 2.2F;
  }
  for (const auto& point : BackProject(depth, EveryPixel())) {
    EXPECT_TRUE(point.point_in_camera.z() == 1.5F || point.point_in_camera.z() == 3.0F);
  }
  DepthFilterOptions keep = EveryPixel();
  keep.edge_radius_px = 0;
  keep.max_incidence_rad = 1.57;
  EXPECT_EQ(BackProject(depth, keep).size(), 64U * 48U);
}

TEST(BackProject, GrazingSurfaceIsDropped) {
  // The plane x = 0.02 m, nearly parallel to the central rays.
  DepthImage depth = Flat(0.0F);
  for (int y = 0; y < 48; ++y) {
    for (int x = 33; x < 64; ++x) depth.At(x, y) = static_cast<float>(0.5 / (x - 31.5));
  }
  DepthFilterOptions options = EveryPixel();
  options.edge_radius_px = 0;
  options.max_incidence_rad = 1.5;
  const auto all = BackProject(depth, options).size();
  options.max_incidence_rad = 1.2;
  EXPECT_LT(BackProject(depth, options).size(), all);
}

TEST(BackProject, SizesThatDisagreeAreAnError) {
  const RgbdCamera camera = TestCamera();
  const ColorImage wrong{32, 48, 3, std::vector<std::uint8_t>(32 * 48 * 3, 0)};
  const RayTable rays = MakeRayTable(camera.color, 1);
  EXPECT_THROW(BackProjectDepth(Flat(1), wrong, rays, camera, 5.0, EveryPixel()), DataError);
}

TEST(RayTable, RemovesDistortion) {
  Camera camera = TestCamera().color;
  camera.k1 = 0.2;
  camera.p1 = 0.003;
  const RayTable rays = MakeRayTable(camera, 2);
  for (int y = 0; y < 48; y += 5) {
    for (int x = 0; x < 64; x += 5) {
      const Eigen::Vector2f ray = rays[static_cast<std::size_t>(y * 64 + x)];
      const auto pixel = camera.Project({ray.x(), ray.y(), 1.0});
      ASSERT_TRUE(pixel.has_value());
      EXPECT_NEAR((*pixel - Eigen::Vector2d(x, y)).norm(), 0, 1e-3);
    }
  }
}

std::vector<StampedPose> PosesAt(std::initializer_list<std::int64_t> times_ns) {
  std::vector<StampedPose> poses;
  for (const auto time_ns : times_ns) poses.push_back({time_ns, {}});
  return poses;
}

TEST(SelectKeyframes, MatchesByTimeAndLeavesOutFramesWithoutDepth) {
  std::vector<FrameRecord> frames(4);
  for (int i = 0; i < 4; ++i) {
    frames[static_cast<std::size_t>(i)].frame_idx = i;
    frames[static_cast<std::size_t>(i)].time_ns = 10 * i;
    frames[static_cast<std::size_t>(i)].depth.path = i == 2 ? "" : "depth.png";
  }
  const std::vector<RgbdCamera> cameras(1);
  const auto keyframes = SelectKeyframes(frames, cameras, PosesAt({0, 20, 30}), 1);
  ASSERT_EQ(keyframes.size(), 2U);
  EXPECT_EQ(keyframes[1].frame.frame_idx, 3);
  EXPECT_EQ(SelectKeyframes(frames, cameras, PosesAt({0, 10, 30}), 2).size(), 2U);
  EXPECT_THROW(SelectKeyframes(frames, cameras, PosesAt({5}), 1), DataError);
  EXPECT_THROW(SelectKeyframes(frames, {}, PosesAt({0}), 1), DataError);
}

}  // namespace nightmap::back_project_test
