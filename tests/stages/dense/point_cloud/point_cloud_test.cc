// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/point_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/geometry/voxel_key.h"
#include "stages/dense/join_clouds/join_clouds.h"
#include "tests/stages/dense/point_cloud/box_room.h"

namespace nightmap::point_cloud_test {

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

TEST(PointCloud, WithoutDepthIsEmpty) {
  BoxRoom room;
  room.with_depth = false;
  EXPECT_TRUE(MakeCloud(TestOptions(), LookAround(room, 3)).points.empty());
}

TEST(PointCloud, ThicknessGrowsWithTheNoise) {
  BoxRoom room;
  const double noisy_m = MakeCloud(TestOptions(), LookAround(room, 8)).plane_thickness_median_m;
  room.noise_scale = 0;
  const double exact_m = MakeCloud(TestOptions(), LookAround(room, 8)).plane_thickness_median_m;
  EXPECT_LT(exact_m, 0.001);
  EXPECT_GT(noisy_m, 2 * exact_m);
}

// The room in tiles of the given edges, the borders anywhere in a voxel, each made by itself.
std::vector<PointCloudResult> MakeTiles(const PointCloudOptions& options,
                                        KeyframeSource source,
                                        double edge_m,
                                        double overlap_m) {
  std::vector<PointCloudResult> tiles;
  for (double x = -3.013; x < 3; x += edge_m) {
    for (double y = -3.511; y < 3.5; y += edge_m) {
      source.region = {{{x, y}, {x + edge_m, y + edge_m}}, overlap_m, options.max_depth_m};
      tiles.push_back(MakeCloud(options, source));
    }
  }
  return tiles;
}

class CloudOfTiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / fmt::format("nightmap_cloud_{}", getpid());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::vector<CloudPoint> Join(const std::vector<PointCloudResult>& tiles, double voxel_size_m) {
    std::vector<PointSource> sources;
    for (const PointCloudResult& tile : tiles) {
      sources.emplace_back([&tile, i = std::size_t{0}]() mutable {
        return i < tile.points.size() ? std::optional(tile.points[i++]) : std::nullopt;
      });
    }
    std::vector<CloudPoint> joined;
    RunJoinClouds(sources, voxel_size_m, [&](const CloudPoint& point) { joined.push_back(point); });
    return joined;
  }

  std::string Bytes(const std::vector<CloudPoint>& points) {
    WritePly(folder_ / "cloud.ply", points);
    return ReadFile(folder_ / "cloud.ply");
  }

  std::filesystem::path folder_;
};

TEST_F(CloudOfTiles, HasTheBytesOfTheWhole) {
  const PointCloudOptions options = TestOptions();
  const KeyframeSource source = LookAround(BoxRoom(), 12);
  const PointCloudResult whole = MakeCloud(options, source);
  ASSERT_GT(whole.num_outliers, 0U);
  for (const double edge_m : {3.6, 1.7}) {
    const auto tiles = MakeTiles(options, source, edge_m, 0.51);
    ASSERT_GE(tiles.size(), 4U);
    EXPECT_EQ(Bytes(Join(tiles, options.voxel_size_m)), Bytes(whole.points));
    std::size_t num_measurements = 0, num_voxels = 0, num_outliers = 0;
    for (const PointCloudResult& tile : tiles) {
      num_measurements += tile.num_measurements;
      num_voxels += tile.num_voxels;
      num_outliers += tile.num_outliers;
    }
    EXPECT_EQ(num_measurements, whole.num_measurements);
    EXPECT_EQ(num_voxels, whole.num_voxels);
    EXPECT_EQ(num_outliers, whole.num_outliers);
  }
}

TEST_F(CloudOfTiles, NeedsEnoughOverlap) {
  const PointCloudOptions options = TestOptions();  // 2 * 0.15 m + 5 * 0.04 m
  EXPECT_THROW(MakeTiles(options, LookAround(BoxRoom(), 2), 3.6, 0.49), UsageError);
}

TEST(PointCloud, PosesFarOutAreAnError) {
  auto source = LookAround(BoxRoom(), 3);
  source.keyframes[1].map_from_camera.translation.x() = 1e9;
  EXPECT_THROW(MakeCloud(TestOptions(), source), DataError);
}

}  // namespace nightmap::point_cloud_test
