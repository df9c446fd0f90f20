// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/octree_io.h"

#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <sstream>
#include <type_traits>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/random.h"
#include "pipeline/dense/octree_reader.h"
#include "tests/dense/octree_hash.h"
#include "tests/test_data.h"

namespace nightmap::octree_io_test {

class OctreeIoTest : public testing::Test {
 protected:
  void ExpectError(const std::string& part) const {
    NIGHTMAP_EXPECT_ERROR(DataError, ReadOctree(ot_), part, "map.ot");
  }

  // Merges files of the parts.
  VoxelCounts Merge(const std::vector<OccupancyTree>& parts) const {
    std::vector<std::filesystem::path> paths;
    for (const OccupancyTree& part : parts) {
      paths.push_back(folder_ / fmt::format("part_{}.ot", paths.size()));
      WriteOctree(paths.back(), part);
    }
    return MergeOctrees(paths, merged_ot_, merged_bt_);
  }

  TemporaryFolder folder_;
  const std::filesystem::path ot_ = folder_ / "map.ot", bt_ = folder_ / "map.bt",
                              merged_ot_ = folder_ / "merged.ot",
                              merged_bt_ = folder_ / "merged.bt";
};

// A checkerboard of voxels around the origin: nothing to merge, both signs of every coordinate.
OccupancyTree Checkerboard() {
  OccupancyTree tree;
  tree.resolution_m = 0.05;
  Random random(3);
  for (int i = 0; i < 512; ++i) {
    const Eigen::Vector3d key(i / 64 - 4, i / 8 % 8 - 4, i % 8 - 4);
    OccupancyVoxel leaf;
    leaf.centre_in_map = (key.array() + 0.5).matrix() * tree.resolution_m;
    leaf.size_m = tree.resolution_m;
    leaf.log_odds = i % 3 == 0 ? 1.5F : -0.25F - static_cast<float>(i) / 1000;
    for (auto& channel : leaf.rgb) channel = static_cast<std::uint8_t>(random.Index(256));
    tree.leaves.push_back(leaf);
  }
  return tree;
}

OccupancyTree OneBlock(float log_odds) {
  OccupancyTree tree = Checkerboard();
  for (auto& leaf : tree.leaves) leaf.log_odds = log_odds;
  return tree;
}

const OccupancyVoxel* LeafAt(const OccupancyTree& tree, const Eigen::Vector3d& point) {
  for (const auto& leaf : tree.leaves) {
    if ((point - leaf.centre_in_map).cwiseAbs().maxCoeff() <= leaf.size_m / 2) return &leaf;
  }
  return nullptr;
}

TEST_F(OctreeIoTest, WhatIsWrittenIsRead) {
  const OccupancyTree written = Checkerboard();
  WriteOctree(ot_, written);
  const OccupancyTree read = ReadOctree(ot_);
  EXPECT_DOUBLE_EQ(read.resolution_m, written.resolution_m);
  ASSERT_EQ(read.leaves.size(), written.leaves.size());
  for (const auto& leaf : written.leaves) {
    const OccupancyVoxel* found = LeafAt(read, leaf.centre_in_map);
    ASSERT_NE(found, nullptr);
    EXPECT_NEAR((found->centre_in_map - leaf.centre_in_map).norm(), 0, 1e-6);
    EXPECT_DOUBLE_EQ(found->size_m, leaf.size_m);
    EXPECT_EQ(found->log_odds, leaf.log_odds);
    EXPECT_EQ(found->rgb, leaf.rgb);
  }
}

TEST_F(OctreeIoTest, ReadingAndWritingAgainGivesTheSameBytes) {
  WriteOctree(ot_, Checkerboard());
  const std::string first = ReadFile(ot_);
  WriteOctree(ot_, ReadOctree(ot_));
  EXPECT_EQ(ReadFile(ot_), first);
}

TEST_F(OctreeIoTest, EqualLeavesAreMergedAndLargeLeavesSurvive) {
  WriteOctree(ot_, OneBlock(-2.0F));
  const OccupancyTree merged = ReadOctree(ot_);
  ASSERT_EQ(merged.leaves.size(), 8U);  // one 4 x 4 x 4 cube in each octant
  EXPECT_DOUBLE_EQ(merged.leaves[0].size_m, 0.2);
  WriteOctree(ot_, merged);
  EXPECT_EQ(ReadOctree(ot_).leaves.size(), 8U);
}

// An OctoMap tree that takes leaves of any size.
template <typename Tree>
class LeafTree : public Tree {
 public:
  explicit LeafTree(const OccupancyTree& tree) : Tree(tree.resolution_m) {
    for (const OccupancyVoxel& leaf : tree.leaves) Insert(leaf);
    this->updateInnerOccupancy();
    this->prune();
  }

 private:
  void Insert(const OccupancyVoxel& leaf) {
    const octomap::OcTreeKey key = this->coordToKey({static_cast<float>(leaf.centre_in_map.x()),
                                                     static_cast<float>(leaf.centre_in_map.y()),
                                                     static_cast<float>(leaf.centre_in_map.z())});
    const int height = static_cast<int>(std::lround(std::log2(leaf.size_m / this->resolution)));
    if (this->root == nullptr) {
      this->root = new std::remove_pointer_t<decltype(this->root)>();
      ++this->tree_size;
    }
    auto* node = this->root;
    for (int level = 15; level >= height; --level) {
      const unsigned child = octomap::computeChildIdx(key, level);
      node = this->nodeChildExists(node, child) ? this->getNodeChild(node, child)
                                                : this->createNodeChild(node, child);
    }
    this->size_changed = true;
    node->setLogOdds(leaf.log_odds);
    if constexpr (std::is_same_v<Tree, octomap::ColorOcTree>) {
      node->setColor(leaf.rgb[0], leaf.rgb[1], leaf.rgb[2]);
    }
  }
};

// Voxels and cubes of 2 and 8 voxels around the origin, none in another; few values, so that many
// merge, and some without a color.
OccupancyTree RandomTree(std::uint64_t seed) {
  Random random(seed);
  OccupancyTree tree;
  tree.resolution_m = 0.1;
  const std::array<float, 3> values = {-2.0F, -0.4F, 0.85F};
  for (int block = 0; block < 64; ++block) {
    const Eigen::Vector3d corner(block / 16 * 8 - 16, block / 4 % 4 * 8 - 16, block % 4 * 8 - 16);
    const int edge = 1 << random.Index(4);
    if (edge == 4) continue;
    const float usual = values[random.Index(values.size())];
    for (int x = 0; x < 8; x += edge) {
      for (int y = 0; y < 8; y += edge) {
        for (int z = 0; z < 8; z += edge) {
          if (block % 3 > 0 && random.Index(9) == 0) continue;
          OccupancyVoxel leaf;
          leaf.size_m = tree.resolution_m * edge;
          leaf.centre_in_map =
              ((corner + Eigen::Vector3d(x, y, z)).array() + 0.5 * edge) * tree.resolution_m;
          const bool is_usual = block % 2 > 0 || random.Index(8) > 0;
          leaf.log_odds = is_usual ? usual : values[random.Index(values.size())];
          if (random.Index(3) > 0) {
            for (auto& channel : leaf.rgb) channel = static_cast<std::uint8_t>(random.Index(256));
          }
          tree.leaves.push_back(leaf);
        }
      }
    }
  }
  return tree;
}

TEST_F(OctreeIoTest, WritesTheBytesThatOctoMapWrites) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const OccupancyTree tree = RandomTree(seed);
    WriteOctree(ot_, tree);
    std::ostringstream by_octomap;
    LeafTree<octomap::ColorOcTree>(tree).write(by_octomap);
    EXPECT_TRUE(WithoutHash(ReadFile(ot_)) == by_octomap.str()) << seed;

    WriteBinaryOctree(bt_, tree);
    LeafTree<octomap::OcTree> binary(tree);
    std::ostringstream binary_by_octomap;
    binary.writeBinary(binary_by_octomap);
    const std::string bytes = ReadFile(bt_);
    const std::string wanted = binary_by_octomap.str();
    const std::string kData = "\ndata\n";
    EXPECT_TRUE(bytes.substr(bytes.find(kData)) == wanted.substr(wanted.find(kData))) << seed;
    EXPECT_THAT(bytes, testing::HasSubstr(fmt::format("\nsize {}\n", binary.size()))) << seed;
  }
}

TEST_F(OctreeIoTest, ReadsTheLeavesThatOctoMapReads) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const auto expect_leaves = [&](auto octomap_tree) {
      octomap_tree.write(ot_.string());
      const OccupancyTree tree = ReadOctree(ot_);
      std::size_t i = 0;
      for (auto leaf = octomap_tree.begin_leafs(); leaf != octomap_tree.end_leafs(); ++leaf, ++i) {
        ASSERT_LT(i, tree.leaves.size());
        const OccupancyVoxel& read = tree.leaves[i];
        EXPECT_EQ(read.centre_in_map, Eigen::Vector3d(leaf.getX(), leaf.getY(), leaf.getZ()));
        EXPECT_EQ(read.size_m, leaf.getSize());
        EXPECT_EQ(read.log_odds, leaf->getLogOdds());
        if constexpr (requires { leaf->getColor(); }) {
          EXPECT_EQ(read.rgb[1], leaf->getColor().g);
        }
      }
      EXPECT_EQ(i, tree.leaves.size());
    };
    expect_leaves(LeafTree<octomap::ColorOcTree>(RandomTree(seed)));
    expect_leaves(LeafTree<octomap::OcTree>(RandomTree(seed)));
  }
}

TEST_F(OctreeIoTest, TheOrderOfTheLeavesDoesNotMatter) {
  OccupancyTree tree = RandomTree(3);
  WriteOctree(ot_, tree);
  WriteBinaryOctree(bt_, tree);
  const std::string ot = ReadFile(ot_);
  const std::string bt = ReadFile(bt_);
  std::ranges::reverse(tree.leaves);
  WriteOctree(ot_, tree);
  WriteBinaryOctree(bt_, tree);
  EXPECT_TRUE(ReadFile(ot_) == ot);
  EXPECT_TRUE(ReadFile(bt_) == bt);
}

TEST_F(OctreeIoTest, LeavesOfAFileComeDepthFirstAsOftenAsTheyAreVisited) {
  WriteOctree(ot_, RandomTree(2));
  const OccupancyTree tree = ReadOctree(ot_);
  const auto wanted = PlaceLeaves(tree, "tree");
  const LeafSource leaves = LeavesOfFile(ot_);
  EXPECT_EQ(leaves.resolution_m, tree.resolution_m);
  for (int pass = 0; pass < 2; ++pass) {
    std::size_t i = 0;
    leaves.visit([&](const PlacedLeaf& leaf) {
      ASSERT_LT(i, wanted.size());
      EXPECT_EQ(leaf.code, wanted[i].code);
      EXPECT_EQ(leaf.height, wanted[i].height);
      EXPECT_EQ(leaf.log_odds, wanted[i].log_odds);
      EXPECT_EQ(leaf.rgb, wanted[i].rgb);
      EXPECT_TRUE(i == 0 || leaf.code > wanted[i - 1].code);
      ++i;
    });
    EXPECT_EQ(i, wanted.size());
  }
}

TEST_F(OctreeIoTest, MergedPartsAreTheWholeTree) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    OccupancyTree tree = RandomTree(seed);
    for (OccupancyVoxel& leaf : tree.leaves) {
      const auto shade = static_cast<std::uint8_t>(leaf.rgb[0] / 2);
      leaf.rgb = {255, 255, 255};
      if (leaf.Occupied()) leaf.rgb = {shade, 7, 200};
    }
    WriteOctree(ot_, tree);
    WriteBinaryOctree(bt_, tree);
    // Parts of single leaves, or of slabs, in which eight leaves may have become one.
    for (const bool slabs : {false, true}) {
      std::vector<OccupancyTree> parts(4, OccupancyTree{tree.resolution_m, {}});
      Random random(seed);
      const double border_m = random.Uniform(-1.0, 1.0);
      for (const OccupancyVoxel& leaf : tree.leaves) {
        const bool left = leaf.centre_in_map.x() < border_m;
        parts[slabs ? (left ? 0 : 1) : random.Index(3)].leaves.push_back(leaf);
      }
      const VoxelCounts counts = Merge(parts);
      EXPECT_TRUE(ReadFile(merged_ot_) == ReadFile(ot_)) << seed;
      EXPECT_TRUE(ReadFile(merged_bt_) == ReadFile(bt_)) << seed;
      VoxelCounts wanted;
      for (const OccupancyVoxel& leaf : tree.leaves) {
        wanted.Add(static_cast<int>(std::lround(std::log2(leaf.size_m / tree.resolution_m))),
                   leaf.Occupied());
      }
      EXPECT_EQ(counts.num_occupied, wanted.num_occupied);
      EXPECT_EQ(counts.num_free, wanted.num_free);
    }
  }
}

TEST_F(OctreeIoTest, MergedWithoutALeafIsAnEmptyTree) {
  const VoxelCounts counts = Merge({{0.05, {}}, {0.05, {}}});
  EXPECT_EQ(counts.num_occupied + counts.num_free, 0U);
  WriteOctree(ot_, {0.05, {}});
  EXPECT_EQ(ReadFile(merged_ot_), ReadFile(ot_));
}

TEST_F(OctreeIoTest, RefusesToMergeTreesThatOverlapOrDifferInResolution) {
  EXPECT_THROW(Merge({Checkerboard(), Checkerboard()}), DataError);
  OccupancyTree coarse = Checkerboard();
  coarse.resolution_m = 0.1;
  for (OccupancyVoxel& leaf : coarse.leaves) {
    leaf.size_m = 0.1;
    leaf.centre_in_map = 2 * leaf.centre_in_map.array() + 10;
  }
  EXPECT_THROW(Merge({Checkerboard(), coarse}), DataError);
}

TEST_F(OctreeIoTest, RefusesToMergeATruncatedPart) {
  WriteOctree(ot_, Checkerboard());
  const std::string bytes = ReadFile(ot_);
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    WriteFile(ot_, bytes.substr(0, size));
    EXPECT_THROW(MergeOctrees({ot_}, merged_ot_, merged_bt_), DataError) << size;
  }
}

TEST_F(OctreeIoTest, RefusesLeavesThatOverlap) {
  for (const double size_m : {0.05, 0.1, 0.2}) {
    OccupancyTree tree = Checkerboard();
    OccupancyVoxel leaf = tree.leaves[300];
    leaf.size_m = size_m;
    tree.leaves.push_back(leaf);
    EXPECT_THROW(WriteOctree(ot_, tree), DataError) << size_m;
  }
}

TEST_F(OctreeIoTest, OctoMapReadsTheColoredTree) {
  const OccupancyTree written = Checkerboard();
  WriteOctree(ot_, written);
  const std::unique_ptr<octomap::AbstractOcTree> read(octomap::AbstractOcTree::read(ot_.string()));
  const auto* tree = dynamic_cast<octomap::ColorOcTree*>(read.get());
  ASSERT_NE(tree, nullptr);
  for (const auto& leaf : written.leaves) {
    const auto* node =
        tree->search(leaf.centre_in_map.x(), leaf.centre_in_map.y(), leaf.centre_in_map.z());
    ASSERT_NE(node, nullptr);
    EXPECT_EQ(tree->isNodeOccupied(node), leaf.Occupied());
    EXPECT_EQ(node->getColor().g, leaf.rgb[1]);
  }
}

TEST_F(OctreeIoTest, OctoMapReadsTheBinaryTree) {
  const OccupancyTree written = Checkerboard();
  WriteBinaryOctree(bt_, written);
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary(bt_.string()));
  EXPECT_NEAR(tree.getResolution(), 0.05, 1e-9);
  for (const auto& leaf : written.leaves) {
    const auto* node =
        tree.search(leaf.centre_in_map.x(), leaf.centre_in_map.y(), leaf.centre_in_map.z());
    ASSERT_NE(node, nullptr);
    EXPECT_EQ(tree.isNodeOccupied(node), leaf.Occupied());
  }
  EXPECT_EQ(tree.search(1.0, 1.0, 1.0), nullptr);
}

TEST_F(OctreeIoTest, OctoMapsOwnToolConvertsTheTree) {
  ASSERT_EQ(std::system("command -v convert_octree >/dev/null"), 0)
      << "octomap-tools is missing: run make deps";
  WriteOctree(ot_, Checkerboard());
  const std::string converted = (folder_ / "converted.bt").string();
  const std::string command =
      fmt::format("convert_octree '{}' '{}' >/dev/null 2>&1", ot_.string(), converted);
  ASSERT_EQ(std::system(command.c_str()), 0);
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary(converted));
  EXPECT_EQ(tree.getNumLeafNodes() > 0, true);
}

TEST_F(OctreeIoTest, EveryTruncationIsRefused) {
  WriteOctree(ot_, Checkerboard());
  const std::string bytes = ReadFile(ot_);
  for (std::size_t size = 0; size < bytes.size(); size += size < 200 ? 1 : 37) {
    WriteFile(ot_, bytes.substr(0, size));
    EXPECT_THROW(ReadOctree(ot_), DataError) << size << " of " << bytes.size() << " bytes";
  }
}

TEST_F(OctreeIoTest, ResolutionsOutOfAllProportionAreRefused) {
  for (const std::string res : {"1e-300", "-0.1", "1e300", "0"}) {
    const std::string text = "# Octomap OcTree file\nid OcTree\nsize 0\nres " + res + "\ndata\n";
    WriteFile(folder_ / "res.ot", text);
    NIGHTMAP_EXPECT_ERROR(DataError, OctreeReader(folder_ / "res.ot"), "res.ot: ", "res");
  }
}

TEST_F(OctreeIoTest, NanIsRefused) {
  WriteOctree(ot_, Checkerboard());
  std::string bytes = WithoutHash(ReadFile(ot_));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bytes.data() + bytes.find("data\n") + 5, &nan, sizeof(nan));
  WriteFile(ot_, bytes);
  ExpectError("not finite");
}

TEST_F(OctreeIoTest, OtherTypesAreRefused) {
  WriteOctree(ot_, Checkerboard());
  std::string bytes = ReadFile(ot_);
  bytes.replace(bytes.find("ColorOcTree"), 11, "StampedTree");
  WriteFile(ot_, bytes);
  ExpectError("field id is 'StampedTree'");
  WriteFile(ot_, "not a tree");
  ExpectError("not an OctoMap .ot file");
}

TEST_F(OctreeIoTest, LeavesThatDoNotFitAreRefused) {
  OccupancyTree tree = Checkerboard();
  tree.leaves[5].size_m = 0.07;
  EXPECT_THROW(WriteOctree(ot_, tree), DataError);
  tree = Checkerboard();
  tree.leaves[5].centre_in_map.x() = 2 * OctreeReach_m(tree.resolution_m);
  EXPECT_THROW(WriteOctree(ot_, tree), DataError);
  tree = Checkerboard();
  tree.leaves[5].log_odds = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(WriteBinaryOctree(bt_, tree), DataError);
}

}  // namespace nightmap::octree_io_test
