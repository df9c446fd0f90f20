// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/octree/octree_of_tiles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "pipeline/base/random.h"
#include "stages/dense/tiles/tiles.h"
#include "tests/stages/dense/point_cloud/box_room.h"
#include "tests/test_data.h"

namespace nightmap::octree_of_tiles_test {

// The room somewhere on the map, with what tiles are made of.
struct Site {
  TilesOptions tiles;
  OctreeOptions octree;
  KeyframeSource source;
  std::vector<CloudPoint> cloud;

  std::map<TileIndex, Tile> Tiles() const {
    return RunTiles(tiles, source.cameras, source.keyframes);
  }
};

// Renders each keyframe once, for all tiles.
void KeepImages(KeyframeSource& source) {
  std::vector<RgbdImages> images;
  for (const Keyframe& keyframe : source.keyframes) images.push_back(source.load(keyframe));
  source.load = [images](const Keyframe& keyframe) {
    return images[static_cast<std::size_t>(keyframe.frame.frame_idx)];
  };
}

// Points all over the walls, but for gaps in which depth has no support.
std::vector<CloudPoint> WallsWithGaps(const BoxRoom& room, Random& random) {
  std::vector<CloudPoint> cloud;
  const Eigen::Vector3d size = room.max_m - room.min_m;
  for (int i = 0; i < 30000; ++i) {
    Eigen::Vector3d place(random.Uniform(), random.Uniform(), random.Uniform());
    place[i % 3] = i % 2;
    if ((place * 6).array().floor().cast<int>().sum() % 4 == 0) continue;
    CloudPoint point;
    point.position_in_map = (room.min_m + place.cwiseProduct(size)).cast<float>();
    cloud.push_back(point);
  }
  return cloud;
}

// Tiles smaller than the room, at a random place on it.
Site RandomSite(std::uint64_t seed) {
  Random random(71, seed);
  Site site;
  site.octree.resolution_m = random.Index(2) == 0 ? 0.05 : 0.1;
  site.octree.max_range_m = random.Uniform(2.0, 2.4);
  site.octree.depth_filter.pixel_stride = 2;
  site.octree.discretize = random.Index(2) == 0;
  site.tiles.max_range_m = site.octree.max_range_m;
  site.tiles.overlap_m = random.Uniform(0.06, 0.3);
  site.tiles.edge_m = random.Uniform(3.5, 4.0);
  const Eigen::Vector3d place(random.Uniform(-9, 9), random.Uniform(-9, 9), 0);
  BoxRoom room;
  room.min_m += place;
  room.max_m += place;
  site.source = LookAround(room, 14);
  for (Keyframe& keyframe : site.source.keyframes) {
    keyframe.keyframe_idx = keyframe.frame.frame_idx;
    keyframe.map_from_camera.translation +=
        place + Eigen::Vector3d(random.Uniform(-1, 1), random.Uniform(-1.5, 1.5), 0);
  }
  KeepImages(site.source);
  site.cloud = WallsWithGaps(room, random);
  return site;
}

// The files of a site's clouds and octrees in tiles.
class TileFiles {
 public:
  TileFiles(const Site& site, std::filesystem::path folder)
      : site_(site), tiles_(site.Tiles()), folder_(std::move(folder)) {
    for (const auto& [index, tile] : tiles_) WriteCloud(index, tile);
  }

  std::size_t NumTiles() const { return tiles_.size(); }

  std::vector<std::filesystem::path> MakeOctrees(int num_threads) const {
    std::vector<std::filesystem::path> octrees;
    for (const auto& [index, tile] : tiles_) {
      KeyframeSource source = site_.source;
      source.keyframes = tile.keyframes;
      source.region = tile.region;
      const auto cloud = ReadCloudAround(CloudsNear(index), tile.region.inside, site_.octree);
      Progress progress("octree", false);
      const auto result = RunOctreeTile(site_.octree, source, &cloud, progress, num_threads);
      octrees.push_back(folder_ / ("tile_" + TileName(index) + ".ot"));
      WriteOctree(octrees.back(), result.tree);
    }
    return octrees;
  }

 private:
  std::filesystem::path CloudPath(const TileIndex& index) const {
    return folder_ / ("tile_" + TileName(index) + ".ply");
  }

  void WriteCloud(const TileIndex& index, const Tile& tile) const {
    std::vector<CloudPoint> points;
    for (const CloudPoint& point : site_.cloud) {
      if (tile.region.inside.Contains(point.position_in_map.head<2>().cast<double>())) {
        points.push_back(point);
      }
    }
    WritePly(CloudPath(index), points);
  }

  std::vector<std::filesystem::path> CloudsNear(const TileIndex& index) const {
    std::vector<std::filesystem::path> clouds;
    for (int i = 0; i < 9; ++i) {
      const TileIndex other{index.first + i / 3 - 1, index.second + i % 3 - 1};
      if (tiles_.contains(other)) clouds.push_back(CloudPath(other));
    }
    return clouds;
  }

  const Site& site_;
  std::map<TileIndex, Tile> tiles_;
  std::filesystem::path folder_;
};

// The octree of all keyframes and the whole cloud at once.
OctreeResult RunWhole(const Site& site) {
  Progress progress("octree", false);
  return RunOctree(site.octree, site.source, &site.cloud, std::nullopt, progress, 2);
}

TEST(OctreeOfTiles, AnyTilingGivesTheBytesOfTheWhole) {
  const TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Site site = RandomSite(seed);
    if (seed % 6 == 0) site.octree.builder = "octomap";
    if (seed >= 6) site.octree.occupancy_threshold = seed % 2 == 0 ? 0.8 : 0.3;
    if (seed >= 6) site.octree.min_keyframes = 2;
    const OctreeResult whole = RunWhole(site);
    EXPECT_GT(whole.num_unsupported, 100U);
    WriteOctree(folder / "whole.ot", whole.tree);
    WriteBinaryOctree(folder / "whole.bt", whole.tree);
    const TileFiles files(site, folder.Path());
    EXPECT_GE(files.NumTiles(), 2U);
    const VoxelCounts counts =
        MergeOctrees(files.MakeOctrees(2), folder / "map.ot", folder / "map.bt");
    EXPECT_TRUE(ReadBytes(folder / "map.ot") == ReadBytes(folder / "whole.ot")) << seed;
    EXPECT_TRUE(ReadBytes(folder / "map.bt") == ReadBytes(folder / "whole.bt")) << seed;
    EXPECT_EQ(counts.num_occupied, whole.num_occupied);
    EXPECT_EQ(counts.num_free, whole.num_free);
  }
}

TEST(OctreeOfTiles, BytesOfATileDoNotDependOnThreads) {
  const TemporaryFolder folder;
  Site site = RandomSite(3);
  site.octree.min_keyframes = 2;
  const TileFiles files(site, folder.Path());
  std::vector<std::string> bytes;
  for (const auto& path : files.MakeOctrees(1)) bytes.push_back(ReadBytes(path));
  for (const int num_threads : {2, 5}) {
    std::vector<std::string> again;
    for (const auto& path : files.MakeOctrees(num_threads)) again.push_back(ReadBytes(path));
    EXPECT_TRUE(again == bytes) << num_threads;
  }
}

// Without the strip of the neighbours' clouds that is read, rays that end there would be lost.
TEST(OctreeOfTiles, ReadsOfTheNeighboursOnlyWhatCanSupportARay) {
  const TemporaryFolder folder;
  std::vector<CloudPoint> points(3);
  points[0].position_in_map = {5, 0, 0};
  points[1].position_in_map = {12.1F, 0, 40};
  points[2].position_in_map = {12.4F, 0, 0};
  WritePly(folder / "a.ply", {points[0]});
  WritePly(folder / "b.ply", {points[1], points[2]});
  OctreeOptions options;
  options.resolution_m = 0.1;
  options.max_range_m = 2;
  const Rectangle tile{{0, -5}, {10, 5}};
  const auto read = ReadCloudAround({folder / "a.ply", folder / "b.ply"}, tile, options);
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[1].position_in_map, points[1].position_in_map);
}

TEST(OctreeOfTiles, RefusesTilesWhoseNeighboursDoNotTellAll) {
  Site site = RandomSite(1);
  KeyframeSource source = site.source;
  const auto expect_error = [&](const Rectangle& inside, double overlap_m, const char* remedy) {
    source.region = {inside, overlap_m, 4.0};
    Progress progress("octree", false);
    try {
      RunOctreeTile(site.octree, source, nullptr, progress, 1);
      FAIL() << "no error; wanted: " << remedy;
    } catch (const UsageError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(remedy));
    }
  };
  expect_error({{0, 0}, {24, 24}}, 0.4 * site.octree.resolution_m, "tiles.overlap_m");
  expect_error({{0, 0}, {2, 2}}, 0.5, "tiles.edge_m");
}

TEST(VoxelsOf, EveryVoxelIsInOneTile) {
  for (const double resolution_m : {0.02, 0.03, 0.05, 0.2}) {
    const double edge_m = 6.1;
    for (int i = 0; i < 2000; ++i) {
      Random random(8, static_cast<std::uint64_t>(i));
      const VoxelKey voxel = VoxelOf(
          {random.Uniform(-15, 15), random.Uniform(-15, 15), random.Uniform(-3, 9)}, resolution_m);
      int num_owners = 0;
      for (int x = -3; x <= 3; ++x) {
        for (int y = -3; y <= 3; ++y) {
          const Rectangle tile{{(x - 0.5) * edge_m, (y - 0.5) * edge_m},
                               {(x + 0.5) * edge_m, (y + 0.5) * edge_m}};
          num_owners += VoxelsOf(tile, resolution_m).Contains(voxel);
        }
      }
      EXPECT_EQ(num_owners, 1);
    }
  }
}

// 0.05 m voxels end at 1638 m; of a tile out there nothing fits.
TEST(VoxelsOf, TilesBeyondTheTreesReachAreEmpty) {
  const VoxelBox box = VoxelsOf({{2.4e9, 0}, {2.4e9 + 24, 24}}, 0.05);
  EXPECT_EQ(box.min.x(), box.max.x());
  EXPECT_FALSE(box.Contains({32767, 3, 3}));
}

}  // namespace nightmap::octree_of_tiles_test
