// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/voxel_labels/voxel_labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/base/random.h"
#include "pipeline/dense/octree_io.h"
#include "stages/dense/octree/octree.h"
#include "tests/stages/dense/point_cloud/box_room.h"
#include "tests/test_data.h"

namespace nightmap::voxel_labels_test {

const std::vector<std::string> kClasses = {"none", "low", "high"};

// A room whose walls have class 1 below z = 0 and class 2 above; keyframes look around in it.
class VoxelLabelsTest : public testing::Test {
 protected:
  void SetUp() override {
    source_ = LookAround(room_, 8);
    OctreeOptions octree;
    octree.max_range_m = options_.max_range_m;
    const OctreeResult result = RunOctree(octree, source_, nullptr, std::nullopt, progress_, 2);
    WriteOctree(folder_ / "map.ot", result.tree);
    occupied_ = ReadOccupiedVoxels(folder_ / "map.ot", {}, {});
  }

  // The class that a pixel truly shows; 0 where `wrong` says so.
  Segmentation Label(const Keyframe& keyframe, double wrong_ratio) const {
    const RgbdCamera& camera = source_.cameras[0];
    const DepthImage depth = source_.load_depth(keyframe);
    Segmentation result{{depth.width, depth.height, 1, {}}, {depth.width, depth.height, 1, {}}};
    Random random(11, static_cast<std::uint64_t>(keyframe.frame.frame_idx));
    const bool is_wrong = random.Uniform() < wrong_ratio;
    for (int y = 0; y < depth.height; ++y) {
      for (int x = 0; x < depth.width; ++x) {
        const auto depth_m = static_cast<double>(depth.pixels[result.labels.pixels.size()]);
        const Eigen::Vector3d point =
            keyframe.map_from_camera * camera.color.BackProject(Eigen::Vector2d(x, y), depth_m);
        const int label = point.z() < 0 ? 1 : 2;
        result.labels.pixels.push_back(static_cast<std::uint8_t>(is_wrong ? 3 - label : label));
        result.confidences.pixels.push_back(200);
      }
    }
    return result;
  }

  VoxelLabels Run(double wrong_ratio, int num_threads, const OccupiedVoxels& occupied) {
    return RunVoxelLabels(
               options_,
               source_,
               [&](const Keyframe& keyframe) { return Label(keyframe, wrong_ratio); },
               kClasses,
               occupied,
               progress_,
               num_threads)
        .voxels;
  }

  // Share of the voxels off the border of the classes whose label is the true one.
  double ShareRight(const VoxelLabels& voxels) const {
    int num_right = 0, num_all = 0;
    for (std::size_t i = 0; i < voxels.Size(); ++i) {
      const double z = VoxelCentre(voxels.keys[i], voxels.resolution_m).z();
      if (std::abs(z) < voxels.resolution_m) continue;
      ++num_all;
      if (LabelOf(voxels, i).label == (z < 0 ? 1 : 2)) ++num_right;
    }
    return static_cast<double>(num_right) / num_all;
  }

  TemporaryFolder folder_;
  BoxRoom room_;
  VoxelLabelsOptions options_;
  KeyframeSource source_;
  OccupiedVoxels occupied_;
  Progress progress_{"test", false};
};

TEST_F(VoxelLabelsTest, EachVoxelGetsTheClassThatWasSeenThere) {
  const VoxelLabels voxels = Run(0, 2, occupied_);
  EXPECT_GT(voxels.Size(), occupied_.codes.size() * 9 / 10);
  EXPECT_EQ(voxels.classes, kClasses);
  EXPECT_GT(ShareRight(voxels), 0.999);
  std::size_t num_unseen = 0;
  for (std::size_t i = 0; i < voxels.Size(); ++i) {
    ASSERT_LE(voxels.num_views[i], 8);
    double sum = 0;
    for (std::size_t v = voxels.vote_offsets[i]; v < voxels.vote_offsets[i + 1]; ++v) {
      sum += voxels.vote_weights[v];
    }
    if (voxels.num_views[i] == 0) {
      ++num_unseen;
      ASSERT_LT(sum, 0.2);  // what the neighbours lend
    } else {
      ASSERT_NEAR(sum, voxels.num_views[i] * 200.0 / 255, 0.02 * sum);  // a keyframe counts once
    }
  }
}

// No hash in its tile's list would tell of other names.
TEST_F(VoxelLabelsTest, WithoutVoxelsThereAreNoNamesOfClasses) {
  source_.keyframes.clear();
  const VoxelLabels voxels = Run(0, 2, occupied_);
  EXPECT_EQ(voxels.Size(), 0U);
  WriteVoxelLabels(folder_ / "v.h5", voxels, "");
  EXPECT_TRUE(ReadVoxelLabels(folder_ / "v.h5").classes.empty());
}

TEST_F(VoxelLabelsTest, MostViewsDecide) {
  options_.spread.spread_iterations = 0;
  options_.depth_filter.pixel_stride = 1;
  source_ = LookAround(room_, 40);
  const VoxelLabels voxels = Run(0.2, 2, occupied_);
  EXPECT_GT(ShareRight(voxels), 0.9);
  int num_unsure = 0;
  for (std::size_t i = 0; i < voxels.Size(); ++i) {
    if (LabelOf(voxels, i).share < 1) ++num_unsure;
  }
  EXPECT_GT(num_unsure, 100);
}

TEST_F(VoxelLabelsTest, IsTheSameAtAnyNumberOfThreads) {
  const VoxelLabels one = Run(0.2, 1, occupied_);
  const VoxelLabels four = Run(0.2, 4, occupied_);
  EXPECT_EQ(one.keys, four.keys);
  EXPECT_EQ(one.num_views, four.num_views);
  EXPECT_EQ(one.vote_offsets, four.vote_offsets);
  EXPECT_EQ(one.vote_labels, four.vote_labels);
  EXPECT_EQ(one.vote_weights, four.vote_weights);
}

TEST_F(VoxelLabelsTest, PartsOfTheTreeGetTheVotesOfTheWhole) {
  options_.spread.spread_iterations = 0;
  const VoxelLabels whole = Run(0.2, 2, occupied_);
  std::map<std::uint64_t, std::vector<float>> weights;
  for (const int side : {0, 1}) {
    OccupiedVoxels part{occupied_.resolution_m, {}, {}};
    for (const std::uint64_t code : occupied_.codes) {
      if ((KeyOfMortonCode(code).x() < 3) == (side == 0)) part.own.push_back(code);
    }
    part.codes = part.own;
    const VoxelLabels voxels = Run(0.2, 2, part);
    for (std::size_t i = 0; i < voxels.Size(); ++i) {
      auto& of_voxel = weights[MortonCode(voxels.keys[i])];
      ASSERT_TRUE(of_voxel.empty());
      for (std::size_t v = voxels.vote_offsets[i]; v < voxels.vote_offsets[i + 1]; ++v) {
        of_voxel.push_back(voxels.vote_weights[v]);
      }
    }
  }
  ASSERT_EQ(weights.size(), whole.Size());
  std::size_t i = 0;
  for (const auto& [code, of_voxel] : weights) {
    ASSERT_EQ(code, MortonCode(whole.keys[i]));
    for (std::size_t v = 0; v < of_voxel.size(); ++v) {
      ASSERT_EQ(of_voxel[v], whole.vote_weights[whole.vote_offsets[i] + v]);
    }
    ++i;
  }
}

TEST_F(VoxelLabelsTest, PixelsBeyondTheRangeAndInFreeSpaceDoNotVote) {
  options_.spread.spread_iterations = 0;
  options_.max_range_m = 2.2;  // the far walls are 2.5 m away
  const VoxelLabels voxels = Run(0, 2, occupied_);
  ASSERT_GT(voxels.Size(), 100U);
  for (const VoxelKey& key : voxels.keys) {
    EXPECT_LT(VoxelCentre(key, voxels.resolution_m).norm(), 2.5);
  }
  const std::vector<std::uint64_t> free = {MortonCode({0, 0, 0})};
  EXPECT_EQ(Run(0, 2, OccupiedVoxels{0.05, free, free}).Size(), 0U);
}

TEST_F(VoxelLabelsTest, AFrameWithoutLabelsIsSkippedByName) {
  source_.keyframes[3].frame.color.path = "third.png";
  const auto result = RunVoxelLabels(
      options_,
      source_,
      [&](const Keyframe& keyframe) {
        if (keyframe.keyframe_idx == 3) throw DataError("no labels");
        return Label(keyframe, 0);
      },
      kClasses,
      occupied_,
      progress_,
      2);
  ASSERT_EQ(result.skipped.size(), 1U);
  EXPECT_THAT(result.skipped[0], testing::HasSubstr("no labels"));
  EXPECT_GT(result.voxels.Size(), 1000U);
}

// A voxel of `size_m` whose lowest corner is `corner`.
OccupancyVoxel Leaf(const Eigen::Vector3d& corner, double size_m, float log_odds) {
  OccupancyVoxel leaf;
  leaf.size_m = size_m;
  leaf.log_odds = log_odds;
  leaf.centre_in_map = corner + Eigen::Vector3d::Constant(size_m / 2);
  return leaf;
}

TEST(OccupiedVoxels, AreTheSmallestOnesOfLargeLeaves) {
  const TemporaryFolder folder;
  OccupancyTree tree;
  tree.resolution_m = 0.1;
  tree.leaves = {Leaf({0, 0, 0}, 0.2, 1), Leaf({0.4, 0, 0}, 0.2, -1)};
  WriteOctree(folder / "map.ot", tree);
  const OccupiedVoxels occupied = ReadOccupiedVoxels(folder / "map.ot", {}, {});
  EXPECT_EQ(occupied.resolution_m, 0.1);
  ASSERT_EQ(occupied.codes.size(), 8U);
  EXPECT_TRUE(std::ranges::is_sorted(occupied.codes));
  EXPECT_EQ(KeyOfMortonCode(occupied.codes.front()), VoxelKey(0, 0, 0));
  EXPECT_EQ(KeyOfMortonCode(occupied.codes.back()), VoxelKey(1, 1, 1));
  EXPECT_EQ(occupied.own, occupied.codes);
}

TEST(OccupiedVoxels, OfNeighboursAreThoseAround) {
  const TemporaryFolder folder;
  OccupancyTree own, neighbour;
  own.resolution_m = neighbour.resolution_m = 0.1;
  own.leaves = {Leaf({0, 0, 0}, 0.1, 1)};
  neighbour.leaves = {Leaf({1, 0, 0}, 0.1, 1), Leaf({3, 0, 0}, 0.1, 1)};
  WriteOctree(folder / "own.ot", own);
  WriteOctree(folder / "neighbour.ot", neighbour);
  const OccupiedVoxels occupied = ReadOccupiedVoxels(
      folder / "own.ot", {folder / "neighbour.ot", folder / "own.ot"}, {{0, 0}, {2, 2}});
  EXPECT_THAT(occupied.own, testing::ElementsAre(MortonCode({0, 0, 0})));
  EXPECT_THAT(occupied.codes, testing::ElementsAre(MortonCode({0, 0, 0}), MortonCode({10, 0, 0})));
}

TEST(OccupiedVoxels, OfALeafThatNoTileHoldsAreNotCounted) {
  const TemporaryFolder folder;
  OccupancyTree tree{0.1, {Leaf({0, 0, 0}, 0.1 * (1 << 14), 0)}};
  WriteOctree(folder / "huge.ot", tree);
  tree.leaves = {Leaf({0, 0, 0}, 0.8, 0)};
  WriteOctree(folder / "own.ot", tree);
  const Rectangle around{{-1, -1}, {7, 7}};
  EXPECT_EQ(ReadOccupiedVoxels(folder / "own.ot", {}, around).own.size(), 512U);
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadOccupiedVoxels(folder / "huge.ot", {}, around),
                        "huge.ot: an occupied leaf of 1638.4 m is larger than a tile");
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadOccupiedVoxels(folder / "own.ot", {folder / "huge.ot"}, around),
                        "huge.ot: an occupied leaf of 1638.4 m is larger than a tile");
}

}  // namespace nightmap::voxel_labels_test
