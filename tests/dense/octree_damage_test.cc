// SPDX-License-Identifier: Apache-2.0
// Damaged octrees are refused before anything is made of their leaves.
#include <algorithm>

#include "pipeline/base/files.h"
#include "pipeline/base/random.h"
#include "pipeline/dense/octree_reader.h"
#include "tests/dense/octree_hash.h"
#include "tests/test_data.h"

namespace nightmap::octree_damage_test {

// Rooms far from each other, so that high up there are nodes whose loss is a leaf of kilometres.
OccupancyTree SomeTree(std::uint64_t seed) {
  Random random(seed);
  OccupancyTree tree{0.05, {}};
  for (const int corner : {-20'000, -400, 0, 9'000}) {
    for (int i = 0; i < 64; ++i) {
      if (random.Index(3) == 0) continue;
      const int floor = random.Index(2) == 0 ? 0 : 64;
      const Eigen::Vector3d key(corner + i / 16, corner + i / 4 % 4, floor + i % 4);
      const bool is_occupied = random.Index(2) == 0;
      OccupancyVoxel leaf{(key.array() + 0.5).matrix() * 0.05, 0.05, is_occupied ? 0.85F : -0.4F};
      if (is_occupied) leaf.rgb = {static_cast<std::uint8_t>(random.Index(256)), 3, 0};
      tree.leaves.push_back(leaf);
    }
  }
  return tree;
}

std::vector<PlacedLeaf> LeavesOf(const std::filesystem::path& path) {
  std::vector<PlacedLeaf> leaves;
  LeavesOfFile(path).visit([&](const PlacedLeaf& leaf) { leaves.push_back(leaf); });
  return leaves;
}

bool AreEqual(const PlacedLeaf& a, const PlacedLeaf& b) {
  return a.code == b.code && a.height == b.height && a.log_odds == b.log_odds && a.rgb == b.rgb;
}

class DamagedOctree : public testing::Test {
 protected:
  // Whether the bytes are refused, naming the file, and before a leaf is given to anyone. If they
  // are not, their leaves are `wanted`.
  bool IsRefused(const std::string& bytes, const std::vector<PlacedLeaf>& wanted) const {
    WriteFile(path_, bytes);
    std::vector<PlacedLeaf> leaves;
    try {
      LeavesOfFile(path_).visit([&](const PlacedLeaf& leaf) { leaves.push_back(leaf); });
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("damaged.ot: "));
      EXPECT_TRUE(leaves.empty());
      EXPECT_THROW(MergeOctrees({path_}, folder_ / "all.ot", folder_ / "all.bt"), DataError);
      EXPECT_THROW(OctreeReader(path_).Next(), DataError);
      return true;
    }
    EXPECT_TRUE(std::ranges::equal(leaves, wanted, AreEqual));
    return false;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "damaged.ot";
};

TEST_F(DamagedOctree, WithAZeroedTailIsRefusedOrTheSame) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    WriteOctree(path_, SomeTree(seed));
    const std::string bytes = ReadFile(path_);
    const auto leaves = LeavesOf(path_);
    Random random(1, seed);
    for (int i = 0; i < 50; ++i) {
      const std::size_t begin =
          i < 8 ? bytes.size() - static_cast<std::size_t>(i) : random.Index(bytes.size());
      std::string damaged = bytes;
      std::fill(damaged.begin() + static_cast<std::ptrdiff_t>(begin), damaged.end(), '\0');
      EXPECT_EQ(IsRefused(damaged, leaves), damaged != bytes) << seed << ' ' << begin;
    }
  }
}

TEST_F(DamagedOctree, WithAnotherBitIsRefusedOrTheSame) {
  WriteOctree(path_, SomeTree(3));
  const std::string bytes = ReadFile(path_);
  const auto leaves = LeavesOf(path_);
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 1 << at % 8);
    const bool is_refused = IsRefused(damaged, leaves);
    EXPECT_TRUE(is_refused || at < bytes.find("id ")) << at;
  }
}

// A file of another program has no hash: the tail of zeros lacks nodes, whatever its nodes are.
TEST_F(DamagedOctree, OfAnotherProgramLacksNodesBehindItsTail) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    WriteOctree(path_, SomeTree(seed));
    const std::string bytes = WithoutHash(ReadFile(path_));
    const std::size_t num_leaves = LeavesOf(path_).size();
    Random random(2, seed);
    for (int i = 0; i < 20; ++i) {
      std::string damaged = bytes;
      const std::size_t begin = bytes.size() / 10 * 9 * random.Index(1000) / 1000;
      std::fill(damaged.begin() + static_cast<std::ptrdiff_t>(begin), damaged.end(), '\0');
      WriteFile(path_, damaged);
      NIGHTMAP_EXPECT_ERROR(DataError, OctreeReader(path_).Next(), "damaged.ot: ");
    }
    WriteFile(path_, bytes);
    EXPECT_EQ(LeavesOf(path_).size(), num_leaves);
  }
}

}  // namespace nightmap::octree_damage_test
