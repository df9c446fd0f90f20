// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/render.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/io/text_file.h"
#include "pipeline/world/paint.h"
#include "pipeline/world/route.h"

namespace nightmap::render_test {

constexpr double kWallDistance_m = 2.0;

Camera SmallCamera() {
  SyntheticCameraOptions options;
  options.image_width_px = 96;
  options.image_height_px = 64;
  options.focal_length_px = 80;
  return options.Pinhole();
}

// A wall 20 m wide and high, in the plane x = 2, seen by cameras that look along +x.
SyntheticWorld WallWorld() {
  Scene scene;
  scene.textures.emplace_back(PaintTexture(Paint::kPoster, 64, 1));
  Surface wall;
  wall.origin = {kWallDistance_m, 10, 10};
  wall.edge_u = {0, -20, 0};
  wall.edge_v = {0, 0, -20};
  wall.label = SurfaceLabel::kWall;
  scene.surfaces.push_back(wall);
  scene.lamps.push_back({{0, 0, 3}, {0.3, 0.3}, 2.0F});
  return WorldOfScene(std::move(scene));
}

DepthSensorOptions NoNoise() {
  DepthSensorOptions sensor;
  sensor.noise_constant_m = sensor.noise_quadratic_per_m = 0;
  sensor.disparity_step_px = sensor.edge_hole_ratio = sensor.dropout_ratio = 0;
  return sensor;
}

// Depth along z of the wall x = 2 behind a pixel.
double AnalyticDepth_m(const Camera& camera, const Rigid3& pose, int x, int y) {
  const Eigen::Vector3d direction = pose.rotation * camera.BackProject({x, y}, 1.0);
  return (kWallDistance_m - pose.translation.x()) / direction.x();
}

TEST(Render, DepthOfWallIsAnalytic) {
  const SyntheticWorld world = WallWorld();
  const Camera camera = SmallCamera();
  const Rigid3 pose = CameraPose({{0.2, -0.3}, 0.3}, 1.1, 0.2, 0.05);
  const RenderedFrame frame = Render(world, camera, pose, NoNoise(), 0, 1);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const double expected_m = AnalyticDepth_m(camera, pose, x, y);
      EXPECT_NEAR(frame.exact_depth.At(x, y), expected_m, 1e-5);
      EXPECT_NEAR(frame.depth.At(x, y), expected_m, 1e-5);
      EXPECT_EQ(frame.labels.At(x, y), static_cast<int>(SurfaceLabel::kWall));
    }
  }
}

// By this file, the profile labels reads the label pictures.
TEST(Render, TheModelFileOfTheLabelPicturesHasTheirClasses) {
  std::string line;
  for (int i = 0; i < kNumSurfaceLabels; ++i) {
    line += std::string(i == 0 ? "classes = [" : ", ") + '"' +
            LabelName(static_cast<SurfaceLabel>(i)) + '"';
  }
  EXPECT_NE(ReadTextFile("configs/labels/models/made_up_building.toml").find(line + "]\n"),
            std::string::npos)
      << line;
}

TEST(Render, WallNormalFacesTheCamera) {
  EXPECT_NEAR(WallWorld().scene.surfaces[0].Normal().x(), -1, 1e-12);
}

TEST(Render, NoiseHasTheStatedDeviation) {
  DepthSensorOptions sensor = NoNoise();
  sensor.noise_constant_m = 0.01;
  const SyntheticWorld world = WallWorld();
  const Rigid3 pose = CameraPose({{0, 0}, 0}, 1, 0);
  const RenderedFrame frame = Render(world, SmallCamera(), pose, sensor, 0, 7);
  double sum = 0;
  for (std::size_t i = 0; i < frame.depth.pixels.size(); ++i) {
    sum += std::pow(frame.depth.pixels[i] - frame.exact_depth.pixels[i], 2);
  }
  const double deviation_m = std::sqrt(sum / static_cast<double>(frame.depth.pixels.size()));
  EXPECT_NEAR(deviation_m, 0.01, 0.0005);
}

TEST(Render, NothingIsMeasuredOutOfRange) {
  DepthSensorOptions sensor = NoNoise();
  sensor.max_depth_m = 1.9;
  const Rigid3 pose = CameraPose({{0, 0}, 0}, 1, 0);
  const RenderedFrame frame = Render(WallWorld(), SmallCamera(), pose, sensor, 0, 7);
  for (const float depth_m : frame.depth.pixels) EXPECT_EQ(depth_m, 0);
}

TEST(Render, SeedDecidesTheNoise) {
  const SyntheticWorld world = WallWorld();
  const Rigid3 pose = CameraPose({{0, 0}, 0.1}, 1, 0);
  const auto render = [&](std::uint64_t seed) {
    return Render(world, SmallCamera(), pose, DepthSensorOptions{}, 2.0, seed);
  };
  EXPECT_EQ(render(3).color.pixels, render(3).color.pixels);
  EXPECT_EQ(render(3).depth.pixels, render(3).depth.pixels);
  EXPECT_NE(render(3).color.pixels, render(4).color.pixels);
  EXPECT_NE(render(3).depth.pixels, render(4).depth.pixels);
  EXPECT_EQ(render(3).exact_depth.pixels, render(4).exact_depth.pixels);
}

TEST(Render, RefusesADistortedCamera) {
  Camera camera = SmallCamera();
  camera.k1 = 0.1;
  EXPECT_THROW(Render(WallWorld(), camera, Rigid3{}, DepthSensorOptions{}, 0, 0), UsageError);
}

}  // namespace nightmap::render_test
