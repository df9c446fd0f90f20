// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/find_map_frame.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "tests/stages/dense/map_frame/level_camera.h"

namespace nightmap::find_map_frame_test {

// Patches of a horizontal square at a height, facing up.
void AddSquare(double height_m, double side_m, Random& random, std::vector<SurfacePatch>* patches) {
  const int count = static_cast<int>(400 * side_m * side_m);
  for (int i = 0; i < count; ++i) {
    const double x = random.Uniform(-side_m / 2, side_m / 2);
    const double y = random.Uniform(-side_m / 2, side_m / 2);
    Eigen::Vector3d normal(0.02 * random.Gaussian(), 0.02 * random.Gaussian(), 1);
    patches->push_back(
        {{x, y, height_m + 0.004 * random.Gaussian()}, normal.normalized(), 1.0 / 400});
  }
}

void AddWall(Random& random, std::vector<SurfacePatch>* patches) {
  for (int i = 0; i < 4000; ++i) {
    patches->push_back({{3, random.Uniform(-3, 3), random.Uniform(0, 2.5)}, {-1, 0, 0}, 1.0 / 400});
  }
}

std::vector<Rigid3> Cameras(double height_m, double pitch_rad) {
  std::vector<Rigid3> cameras;
  for (int i = 0; i < 5; ++i) cameras.push_back(Looking(0.2 * i, height_m, pitch_rad));
  return cameras;
}

// Moves the observations into another frame of reference.
void Move(const Rigid3& motion, std::vector<SurfacePatch>* patches, std::vector<Rigid3>* cameras) {
  for (SurfacePatch& patch : *patches) {
    patch.point = motion * patch.point;
    patch.normal = motion.rotation * patch.normal;
  }
  for (Rigid3& camera : *cameras) camera = motion * camera;
}

TEST(FindMapFrame, PutsTheFloorAtZeroWhateverTheGivenFrame) {
  Random random(1);
  for (int trial = 0; trial < 8; ++trial) {
    std::vector<SurfacePatch> patches;
    AddSquare(0, 4, random, &patches);
    AddSquare(0.75, 1.5, random, &patches);  // a table
    AddWall(random, &patches);
    auto cameras = Cameras(1.2, 0.3);
    const Rigid3 motion{Eigen::Quaterniond(Eigen::AngleAxisd(
                            random.Uniform(0, 3), Eigen::Vector3d(1, 2, -1).normalized())),
                        {1, 2, 3}};
    Move(motion, &patches, &cameras);
    const MapFrame frame = FindMapFrame({}, patches, cameras, Held(cameras));
    EXPECT_EQ(frame.floor_source, "floor plane");
    EXPECT_EQ(frame.gravity_source, "horizontal surfaces");
    EXPECT_NEAR(frame.camera_height_m, 1.2, 0.01);
    EXPECT_NEAR(frame.floor_area_m2, 16, 2);
    const Rigid3 first = frame.map_from_given * cameras[0];
    EXPECT_NEAR(first.translation.head<2>().norm(), 0, 1e-9);
    const Eigen::Vector3d up =
        frame.map_from_given.rotation * (motion.rotation * Eigen::Vector3d::UnitZ());
    EXPECT_LT(std::acos(std::min(1.0, up.z())), 0.005);
    EXPECT_GT((first.rotation * Eigen::Vector3d::UnitZ()).x(), 0.9);  // looks along x
  }
}

TEST(FindMapFrame, SmallPlaneIsNotCalledAFloor) {
  Random random(2);
  std::vector<SurfacePatch> patches;
  AddSquare(0, 0.3, random, &patches);
  const MapFrame frame = FindMapFrame({}, patches, Cameras(0.6, 0.5), Held(Cameras(0.6, 0.5)));
  EXPECT_EQ(frame.floor_source, "lowest horizontal plane");
  EXPECT_NEAR(frame.camera_height_m, 0.6, 0.01);
}

TEST(FindMapFrame, WithoutAnySurfaceItFallsBackToTheCameras) {
  const MapFrame frame = FindMapFrame({}, {}, Cameras(1, 0), Held(Cameras(1, 0)));
  EXPECT_EQ(frame.gravity_source, "camera attitude");
  EXPECT_EQ(frame.floor_source, "lowest camera");
  EXPECT_TRUE(frame.map_from_given.Matrix().allFinite());
}

TEST(FindMapFrame, AccelerometerDecidesWhereTheCameraIsTilted) {
  Random random(3);
  std::vector<SurfacePatch> patches;
  AddWall(random, &patches);  // a tilted camera takes a wall for the floor without gravity
  AddSquare(0, 3, random, &patches);
  const auto cameras = Cameras(1.2, 1.3);  // looks almost straight down
  UpInput input = Held(cameras);
  input.measured_in_given = Eigen::Vector3d::UnitZ();
  const MapFrame frame = FindMapFrame({}, patches, cameras, input);
  EXPECT_EQ(frame.gravity_source, "accelerometer");
  EXPECT_EQ(frame.floor_source, "floor plane");
  EXPECT_NEAR(frame.camera_height_m, 1.2, 0.01);
}

TEST(SamplePatches, MeasuresPlanes) {
  RgbdCamera camera;
  camera.color = Camera{320, 240, 260, 260, 159.5, 119.5};
  // The floor 1 m below a level camera: z = 1 / y for normalized y.
  DepthImage depth{320, 240, 1, std::vector<float>(320 * 240)};
  for (int y = 140; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      depth.At(x, y) = static_cast<float>(260 / (y - 119.5));
    }
  }
  const Rigid3 given_from_camera = Looking(0, 1, 0);
  const auto patches = SamplePatches(depth, camera, given_from_camera, 4);
  ASSERT_GT(patches.size(), 50U);
  for (const SurfacePatch& patch : patches) {
    EXPECT_NEAR(patch.point.z(), 0, 1e-5);
    EXPECT_NEAR(patch.normal.z(), 1, 1e-5);
    EXPECT_LE(patch.point.x(), 4);
    EXPECT_GT(patch.area_m2, 0);
  }
}

TEST(SamplePatches, NothingWhereNothingWasMeasured) {
  RgbdCamera camera;
  camera.color = Camera{64, 48, 50, 50, 32, 24};
  const DepthImage depth{64, 48, 1, std::vector<float>(64 * 48)};
  EXPECT_TRUE(SamplePatches(depth, camera, Rigid3(), 4).empty());
}

}  // namespace nightmap::find_map_frame_test
