// SPDX-License-Identifier: Apache-2.0
#include "stages/point_cloud/point_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/geometry/voxel_key.h"
#include "tests/stages/point_cloud/box_room.h"

namespace nightmap {
namespace {

PointCloudOptions TestOptions() {
  PointCloudOptions options;
  options.depth_filter.pixel_stride = 1;
  options.voxel_size_m = 0.04;
  options.surface_radius_m = 0.15;
  return options;
}

PointCloudResult MakeCloud(const PointCloudOptions& options,
                           const KeyframeSource& source,
                           int num_threads = 2) {
  Progress progress("point_cloud", false);
  return RunPointCloud(options, source, progress, num_threads);
}

double MedianDistanceToWall_m(const BoxRoom& room, const PointCloudResult& result) {
  std::vector<double> distances;
  for (const auto& point : result.points) {
    distances.push_back(room.DistanceToWall_m(point.position_in_map.cast<double>()));
  }
  std::nth_element(distances.begin(),
                   distances.begin() + static_cast<long>(distances.size() / 2),
                   distances.end());
  return distances[distances.size() / 2];
}

TEST(PointCloud, LiesOnTheWallsWithoutNoise) {
  BoxRoom room;
  room.noise_scale = 0;
  const auto result = MakeCloud(TestOptions(), LookAround(room, 12));
  ASSERT_GT(result.points.size(), 5000U);
  EXPECT_LT(MedianDistanceToWall_m(room, result), 0.001);
  EXPECT_EQ(result.num_measurements > 0, true);
}

TEST(PointCloud, AveragesBelowTheDepthNoise) {
  const BoxRoom room;
  const auto result = MakeCloud(TestOptions(), LookAround(room, 24));
  const double noise_at_nearest_wall_m = DepthNoise().Sigma_m(2.0);
  EXPECT_LT(MedianDistanceToWall_m(room, result), 0.5 * noise_at_nearest_wall_m);
}

TEST(PointCloud, ProjectionToTheSurfaceReducesNoise) {
  const BoxRoom room;
  PointCloudOptions options = TestOptions();
  const double projected_m = MedianDistanceToWall_m(room, MakeCloud(options, LookAround(room, 12)));
  options.project_to_surface = false;
  const double plain_m = MedianDistanceToWall_m(room, MakeCloud(options, LookAround(room, 12)));
  EXPECT_LT(projected_m, 0.7 * plain_m);
}

TEST(PointCloud, HasAtMostOnePointPerVoxelInOrder) {
  const PointCloudOptions options = TestOptions();
  const auto result = MakeCloud(options, LookAround(BoxRoom(), 12));
  std::uint64_t previous = 0;
  for (const auto& point : result.points) {
    const auto key = PackVoxel(VoxelOf(point.position_in_map.cast<double>(), options.voxel_size_m));
    ASSERT_GT(key, previous);
    previous = key;
  }
}

TEST(PointCloud, NormalsAreUnitAndFaceTheCamera) {
  const auto result = MakeCloud(TestOptions(), LookAround(BoxRoom(), 12));
  for (const auto& point : result.points) {
    EXPECT_NEAR(point.normal_in_map.norm(), 1, 1e-5);
    EXPECT_LT(point.normal_in_map.dot(point.position_in_map), 0.2F);  // cameras are at the middle
  }
}

TEST(PointCloud, KeepsColor) {
  const auto result = MakeCloud(TestOptions(), LookAround(BoxRoom(), 4));
  for (const auto& point : result.points)
    EXPECT_EQ(point.rgb, (std::array<std::uint8_t, 3>{90, 90, 90}));
}

TEST(PointCloud, IsTheSameAtAnyNumberOfThreads) {
  const auto source = LookAround(BoxRoom(), 12);
  const auto path =
      std::filesystem::temp_directory_path() / fmt::format("nightmap_threads_{}.ply", getpid());
  WritePly(path, MakeCloud(TestOptions(), source, 1).points);
  const std::string one = ReadFile(path);
  WritePly(path, MakeCloud(TestOptions(), source, 2).points);
  EXPECT_EQ(ReadFile(path), one);
  WritePly(path, MakeCloud(TestOptions(), source, 5).points);
  EXPECT_EQ(ReadFile(path), one);
  std::filesystem::remove(path);
}

TEST(PointCloud, SkipsUnreadableFramesWithTheReason) {
  BoxRoom room;
  room.unreadable = {2, 5};
  const auto result = MakeCloud(TestOptions(), LookAround(room, 8));
  EXPECT_THAT(result.skipped, testing::ElementsAre("frame 2: truncated", "frame 5: truncated"));
  EXPECT_FALSE(result.points.empty());
}

TEST(PointCloud, WithoutDepthIsAnErrorWithARemedy) {
  BoxRoom room;
  room.with_depth = false;
  try {
    MakeCloud(TestOptions(), LookAround(room, 3));
    FAIL() << "no error";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("depth_units_per_m"));
  }
}

TEST(PointCloud, PosesFarOutAreAnError) {
  auto source = LookAround(BoxRoom(), 3);
  source.keyframes[1].map_from_camera.translation.x() = 1e9;
  EXPECT_THROW(MakeCloud(TestOptions(), source), DataError);
}

}  // namespace
}  // namespace nightmap
