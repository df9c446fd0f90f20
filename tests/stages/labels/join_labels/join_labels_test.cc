// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/join_labels/join_labels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "pipeline/base/files.h"
#include "pipeline/base/input_error.h"
#include "pipeline/base/random.h"
#include "pipeline/dense/octree_io.h"
#include "pipeline/dense/octree_reader.h"
#include "tests/test_data.h"

namespace nightmap::join_labels_test {

constexpr double kResolution_m = 0.1;
const std::vector<Rgb> kPalette = {{0, 0, 0}, {255, 0, 0}, {0, 255, 0}, {0, 0, 255}};

// Adds a voxel; keys must come in Morton order.
void Add(const VoxelKey& key, const std::map<std::uint8_t, float>& votes, VoxelLabels* voxels) {
  voxels->keys.push_back(key);
  voxels->num_views.push_back(3);
  for (const auto& [label, weight] : votes) {
    voxels->vote_labels.push_back(label);
    voxels->vote_weights.push_back(weight);
  }
  voxels->vote_offsets.push_back(voxels->vote_labels.size());
}

VoxelLabels Empty() {
  VoxelLabels voxels;
  voxels.resolution_m = kResolution_m;
  voxels.classes = {"none", "chair", "table", "wall"};
  return voxels;
}

// Random voxels with random votes, in two parts that each hold some.
struct Parts {
  VoxelLabels whole = Empty(), left = Empty(), right = Empty();
};

Parts RandomParts(std::uint64_t seed) {
  Random random(5, seed);
  std::map<std::uint64_t, VoxelKey> keys;
  for (int i = 0; i < 400; ++i) {
    const auto axis = [&] { return static_cast<int>(random.Index(12)) - 6; };
    const VoxelKey key(axis(), axis(), axis());
    keys[MortonCode(key)] = key;
  }
  Parts parts;
  for (const auto& [code, key] : keys) {
    std::map<std::uint8_t, float> votes;
    votes[static_cast<std::uint8_t>(random.Index(4))] = static_cast<float>(random.Uniform(0.1, 5));
    votes[static_cast<std::uint8_t>(random.Index(4))] = static_cast<float>(random.Uniform(0.1, 5));
    Add(key, votes, &parts.whole);
    Add(key, votes, key.x() < 1 ? &parts.left : &parts.right);
  }
  return parts;
}

void ExpectEqual(const VoxelLabels& a, const VoxelLabels& b) {
  EXPECT_EQ(a.keys, b.keys);
  EXPECT_EQ(a.classes, b.classes);
  EXPECT_EQ(a.num_views, b.num_views);
  EXPECT_EQ(a.vote_offsets, b.vote_offsets);
  EXPECT_EQ(a.vote_labels, b.vote_labels);
  EXPECT_EQ(a.vote_weights, b.vote_weights);
}

// Occupied where `voxels` are, free in a cube beside.
OccupancyTree TreeOf(const VoxelLabels& voxels) {
  OccupancyTree tree;
  tree.resolution_m = kResolution_m;
  for (const VoxelKey& key : voxels.keys) {
    tree.leaves.push_back({VoxelCentre(key, kResolution_m), kResolution_m, 1.5F, {9, 9, 9}});
  }
  tree.leaves.push_back({Eigen::Vector3d::Constant(2.4), 1.6, -1.0F, {255, 255, 255}});
  return tree;
}

OccupancyTree Labelled(const TemporaryFolder& folder, const VoxelLabels& voxels) {
  WriteLabelledOctree(folder / "labels.ot", LeavesOfTree(TreeOf(voxels)), voxels, kPalette);
  return ReadOctree(folder / "labels.ot");
}

TEST(JoinLabels, PartsInAnyOrderGiveTheWhole) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Parts parts = RandomParts(seed);
    ExpectEqual(JoinVoxelLabels({parts.left, parts.right}), parts.whole);
    VoxelLabels unlabelled = Empty();
    unlabelled.classes.clear();
    ExpectEqual(JoinVoxelLabels({unlabelled, parts.right, Empty(), parts.left}), parts.whole);
  }
}

TEST(JoinLabels, RefusesPartsThatOverlapOrDiffer) {
  const Parts parts = RandomParts(1);
  NIGHTMAP_EXPECT_ERROR(InputError,
                        JoinVoxelLabels({Empty(), parts.left, parts.left}),
                        "tile_labels[1], tile_labels[2]: both label the voxel at");
  VoxelLabels other = Empty();
  other.classes.back() = "floor";
  NIGHTMAP_EXPECT_ERROR(InputError,
                        JoinVoxelLabels({parts.left, other}),
                        "tile_labels[0], tile_labels[1]: they differ");
  other = Empty();
  other.resolution_m = 0.2;
  NIGHTMAP_EXPECT_ERROR(InputError,
                        JoinVoxelLabels({parts.left, other}),
                        "tile_labels[0], tile_labels[1]: they differ");
}

TEST(LabelledOctree, HasTheColorOfEachVoxelsClassAndNoOther) {
  const TemporaryFolder folder;
  const VoxelLabels voxels = RandomParts(2).whole;
  std::map<std::uint64_t, Rgb> colors;
  for (const OccupancyVoxel& leaf : Labelled(folder, voxels).leaves) {
    if (!leaf.Occupied()) {
      EXPECT_EQ(leaf.rgb, (Rgb{255, 255, 255}));
      continue;
    }
    ASSERT_NE(std::ranges::find(kPalette, leaf.rgb), kPalette.end());
    ASSERT_NEAR(leaf.size_m, kResolution_m, 1e-9);
    colors[MortonCode(VoxelOf(leaf.centre_in_map, kResolution_m))] = leaf.rgb;
  }
  ASSERT_EQ(colors.size(), voxels.Size());
  for (std::size_t i = 0; i < voxels.Size(); ++i) {
    EXPECT_EQ(colors[MortonCode(voxels.keys[i])], kPalette[LabelOf(voxels, i).label]);
  }
}

// The eight voxels of a cube, all chairs but the first.
VoxelLabels Cube(std::uint8_t first) {
  VoxelLabels voxels = Empty();
  for (std::uint64_t i = 0; i < 8; ++i) {
    Add(KeyOfMortonCode(MortonCode({0, 0, 0}) + i), {{i == 0 ? first : 1, 1.0F}}, &voxels);
  }
  return voxels;
}

TEST(LabelledOctree, MergesVoxelsOfOneClassOnly) {
  const TemporaryFolder folder;
  EXPECT_EQ(Labelled(folder, Cube(1)).leaves.size(), 2U);
  EXPECT_EQ(Labelled(folder, Cube(2)).leaves.size(), 9U);
}

TEST(LabelledOctree, InnerNodesHaveTheClassThatMostVotesSpeakFor) {
  const TemporaryFolder folder;
  VoxelLabels voxels = Cube(2);
  voxels.vote_weights[0] = 9;  // one table outvotes seven chairs
  Labelled(folder, voxels);
  const std::string bytes = ReadFile(folder / "labels.ot");
  const std::size_t root = bytes.find("data\n") + 5;
  const auto color = [&](std::size_t node) {
    Rgb rgb;
    std::memcpy(rgb.data(), bytes.data() + root + 8 * node + 4, 3);
    return rgb;
  };
  EXPECT_EQ(color(0), kPalette[2]);
}

TEST(LabelledOctree, LargeOccupiedLeavesGetTheClassesOfTheirVoxels) {
  const TemporaryFolder folder;
  OccupancyTree tree;
  tree.resolution_m = kResolution_m;
  tree.leaves = {{Eigen::Vector3d::Constant(0.1), 0.2, 1.5F, {9, 9, 9}}};
  WriteLabelledOctree(folder / "labels.ot", LeavesOfTree(tree), Cube(3), kPalette);
  const OccupancyTree labelled = ReadOctree(folder / "labels.ot");
  ASSERT_EQ(labelled.leaves.size(), 8U);
  EXPECT_EQ(labelled.leaves[0].rgb, kPalette[3]);
  EXPECT_EQ(labelled.leaves[1].rgb, kPalette[1]);
}

// As damage makes them: it is taken apart only around its labels.
TEST(LabelledOctree, OfALeafOfKilometresTakesNoMoreWorkThanItsLabels) {
  const TemporaryFolder folder;
  const int height = 14;
  const double size_m = kResolution_m * (1 << height);
  const OccupancyTree tree{kResolution_m, {{Eigen::Vector3d::Constant(size_m / 2), size_m, 0, {}}}};
  WriteLabelledOctree(folder / "labels.ot", LeavesOfTree(tree), Cube(3), kPalette);
  const OccupancyTree labelled = ReadOctree(folder / "labels.ot");
  ASSERT_EQ(labelled.leaves.size(), 8U + 7U * (height - 1));
  EXPECT_EQ(labelled.leaves[0].rgb, kPalette[3]);
  EXPECT_EQ(labelled.leaves.back().rgb, (Rgb{255, 255, 255}));
}

TEST(LabelledOctree, VoxelsWithoutVotesHaveNoColor) {
  const TemporaryFolder folder;
  const OccupancyTree tree = TreeOf(Cube(2));
  WriteLabelledOctree(folder / "labels.ot", LeavesOfTree(tree), Empty(), kPalette);
  for (const OccupancyVoxel& leaf : ReadOctree(folder / "labels.ot").leaves) {
    EXPECT_EQ(leaf.rgb, (Rgb{255, 255, 255}));
  }
}

TEST(LabelAt, IsTheClassOfTheVoxel) {
  const VoxelLabels voxels = Cube(2);
  const LabelAt label_at(voxels);
  EXPECT_EQ(label_at({0.05, 0.05, 0.05}), 2);
  EXPECT_EQ(label_at({0.15, 0.05, 0.05}), 1);
  EXPECT_EQ(label_at({0.25, 0.05, 0.05}), 0);
}

TEST(Legend, HasNamesColorsAndNumbers) {
  const auto legend = nlohmann::json::parse(LegendJson(Cube(2), kPalette));
  ASSERT_EQ(legend["classes"].size(), 4U);
  EXPECT_EQ(legend["classes"][1]["name"], "chair");
  EXPECT_EQ(legend["classes"][1]["color"], "#ff0000");
  EXPECT_EQ(legend["classes"][1]["num_voxels"], 7);
  EXPECT_EQ(legend["classes"][2]["num_voxels"], 1);
}

}  // namespace nightmap::join_labels_test
