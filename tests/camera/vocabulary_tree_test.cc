// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/vocabulary_tree.h"

#include <set>
#include <stdexcept>

#include "pipeline/camera/descriptor_distance.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::vocabulary_tree_test {

std::vector<std::uint8_t> RandomDescriptors(DescriptorKind kind, int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::uint8_t> all;
  for (int i = 0; i < count; ++i) {
    if (kind == DescriptorKind::kRootSift) {
      const auto descriptor = RandomRootSift(random);
      all.insert(all.end(), descriptor.begin(), descriptor.end());
    } else {
      for (int k = 0; k < DescriptorSize(kind); ++k) {
        all.push_back(static_cast<std::uint8_t>(random.Index(256)));
      }
    }
  }
  return all;
}

class VocabularyTreeTest : public testing::TestWithParam<DescriptorKind> {
 protected:
  std::size_t Size() const { return static_cast<std::size_t>(DescriptorSize(GetParam())); }
  const std::uint8_t* Descriptor(int i) const {
    return &descriptors_[static_cast<std::size_t>(i) * Size()];
  }
  std::vector<int> VisitedLeaves(const std::uint8_t* descriptor) const {
    std::vector<int> leaves;
    tree_.VisitLeaves(descriptor, [&](int leaf) {
      leaves.push_back(leaf);
      return true;
    });
    return leaves;
  }
  std::vector<int> Parents() const {
    std::vector<int> parents(tree_.Nodes().size(), -1);
    for (std::size_t i = 0; i < parents.size(); ++i) {
      const auto& node = tree_.Nodes()[i];
      for (int k = 0; k < node.num_children; ++k) {
        parents[static_cast<std::size_t>(node.first_child + k)] = static_cast<int>(i);
      }
    }
    return parents;
  }
  std::vector<int> DistancesToCentres(const std::uint8_t* descriptor) const {
    std::vector<int> distances;
    for (std::size_t i = 0; i < tree_.Nodes().size(); ++i) {
      const std::uint8_t* centre = &tree_.Centres()[i * Size()];
      distances.push_back(DescriptorDistance(GetParam(), descriptor, centre));
    }
    return distances;
  }
  // Farthest nodes on the paths from the last common node to each of two leaves.
  static std::pair<int, int> FarthestSteps(int leaf_a,
                                           int leaf_b,
                                           const std::vector<int>& parents,
                                           const std::vector<int>& distances) {
    std::set<int> above_a;
    for (int node = leaf_a; node >= 0; node = parents[static_cast<std::size_t>(node)]) {
      above_a.insert(node);
    }
    const auto climb = [&](int node, const auto& is_common) {
      int farthest = 0;
      for (; !is_common(node); node = parents[static_cast<std::size_t>(node)]) {
        farthest = std::max(farthest, distances[static_cast<std::size_t>(node)]);
      }
      return std::pair(farthest, node);
    };
    const auto [of_b, common] = climb(leaf_b, [&](int node) { return above_a.contains(node); });
    const auto of_a = climb(leaf_a, [&, last = common](int node) { return node == last; });
    return {of_a.first, of_b};
  }
  static constexpr int kCount = 3000;
  std::vector<std::uint8_t> descriptors_ = RandomDescriptors(GetParam(), kCount, 1);
  VocabularyTree tree_ = VocabularyTree::Train(descriptors_, GetParam(), {}, 1);
};

TEST_P(VocabularyTreeTest, IsTheSameForOneAndTwoThreads) {
  const auto other = VocabularyTree::Train(descriptors_, GetParam(), {}, 2);
  EXPECT_EQ(tree_.Centres(), other.Centres());
  EXPECT_EQ(tree_.NumNodes(), other.NumNodes());
  EXPECT_EQ(tree_.LeafWords(descriptors_, 1), other.LeafWords(descriptors_, 2));
}

TEST_P(VocabularyTreeTest, WordsAreThePathsPrefix) {
  for (int i = 0; i < kCount; i += 100) {
    const std::vector<int> path = tree_.Path(Descriptor(i));
    ASSERT_FALSE(path.empty());
    for (int level = 1; level <= tree_.Depth(); ++level) {
      const auto at = std::min(static_cast<std::size_t>(level), path.size()) - 1;
      EXPECT_EQ(tree_.Word(Descriptor(i), level), path[at]);
    }
    EXPECT_EQ(tree_.LeafWord(Descriptor(i)), path.back());
    EXPECT_EQ(tree_.Nodes()[static_cast<std::size_t>(path.back())].num_children, 0);
  }
}

TEST_P(VocabularyTreeTest, EveryLeafIsVisitedOnceFromTheNearestOn) {
  int num_leaves = 0;
  for (const auto& node : tree_.Nodes()) num_leaves += node.num_children == 0;
  for (int i = 0; i < kCount; i += 300) {
    const std::vector<int> leaves = VisitedLeaves(Descriptor(i));
    EXPECT_EQ(leaves[0], tree_.LeafWord(Descriptor(i)));
    EXPECT_EQ(static_cast<int>(leaves.size()), num_leaves);
    EXPECT_EQ(std::set<int>(leaves.begin(), leaves.end()).size(), leaves.size());
    int num_visited = 0;
    tree_.VisitLeaves(Descriptor(i), [&](int) { return ++num_visited < 5; });
    EXPECT_EQ(num_visited, 5);
  }
}

// The best branch is next. So of two leaves the one comes first to which, from where their ways
// part, no step is as far as the farthest to the other.
TEST_P(VocabularyTreeTest, LeavesAreVisitedInTheOrderOfTheBestBranch) {
  const std::vector<int> parents = Parents();
  for (int i = 0; i < kCount; i += 300) {
    const std::vector<int> distances = DistancesToCentres(Descriptor(i));
    const std::vector<int> leaves = VisitedLeaves(Descriptor(i));
    for (std::size_t k = 1; k < leaves.size(); ++k) {
      const auto [before, after] = FarthestSteps(leaves[k - 1], leaves[k], parents, distances);
      ASSERT_LE(before, after) << "leaf " << k;
    }
  }
}

TEST_P(VocabularyTreeTest, EachStepGoesToTheNearestChild) {
  for (int i = 0; i < kCount; i += 100) {
    int node = 0;
    for (const int next : tree_.Path(Descriptor(i))) {
      const auto& parent = tree_.Nodes()[static_cast<std::size_t>(node)];
      const auto distance = [&](int child) {
        const auto offset = static_cast<std::size_t>(child) * Size();
        return DescriptorDistance(GetParam(), Descriptor(i), &tree_.Centres()[offset]);
      };
      for (int k = 0; k < parent.num_children; ++k) {
        EXPECT_LE(distance(next), distance(parent.first_child + k));
      }
      node = next;
    }
  }
}

TEST_P(VocabularyTreeTest, SplitsItsDescriptorsAmongManyWords) {
  const auto words = tree_.LeafWords(descriptors_, 1);
  EXPECT_GT(std::set<int>(words.begin(), words.end()).size(), 300U);
}

INSTANTIATE_TEST_SUITE_P(Kinds,
                         VocabularyTreeTest,
                         testing::Values(DescriptorKind::kRootSift,
                                         DescriptorKind::kOrb,
                                         DescriptorKind::kBrisk));

// Ten tight clusters: k-means++ and Lloyd must find them.
TEST(VocabularyTreeTrainTest, SeparatesClusters) {
  Random random(3);
  std::vector<std::uint8_t> all;
  std::vector<int> cluster_of;
  for (int cluster = 0; cluster < 10; ++cluster) {
    const auto centre = RandomRootSift(random);
    for (int i = 0; i < 30; ++i) {
      for (const std::uint8_t value : centre) {
        const int noisy = value + static_cast<int>(random.Index(5)) - 2;
        all.push_back(static_cast<std::uint8_t>(std::clamp(noisy, 0, 255)));
      }
      cluster_of.push_back(cluster);
    }
  }
  const auto tree = VocabularyTree::Train(all, DescriptorKind::kRootSift, {.depth = 1}, 1);
  EXPECT_EQ(tree.NumNodes(), 11);
  const auto words = tree.LeafWords(all, 1);
  std::set<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < words.size(); ++i) pairs.emplace(cluster_of[i], words[i]);
  EXPECT_EQ(pairs.size(), 10U);
}

TEST(VocabularyTreeTrainTest, StopsAtEqualAndAtFewDescriptors) {
  const std::vector<std::uint8_t> equal(128 * 100, 40);
  EXPECT_EQ(VocabularyTree::Train(equal, DescriptorKind::kRootSift, {}, 1).NumNodes(), 1);
  const auto few = RandomDescriptors(DescriptorKind::kOrb, 5, 1);
  const auto tree = VocabularyTree::Train(few, DescriptorKind::kOrb, {}, 1);
  EXPECT_EQ(tree.NumNodes(), 1);
  EXPECT_EQ(tree.LeafWord(few.data()), 0);
  NIGHTMAP_EXPECT_ERROR(
      DataError, VocabularyTree::Train({}, DescriptorKind::kOrb, {}, 1), "no descriptors");
}

TEST(VocabularyTreeTrainTest, DependsOnTheSeed) {
  const auto descriptors = RandomDescriptors(DescriptorKind::kRootSift, 500, 1);
  EXPECT_NE(
      VocabularyTree::Train(descriptors, DescriptorKind::kRootSift, {}, 1).Centres(),
      VocabularyTree::Train(descriptors, DescriptorKind::kRootSift, {.seed = 1}, 1).Centres());
}

TEST(VocabularyTreeNodesTest, RefusesWhatIsNoTree) {
  using Node = VocabularyTree::Node;
  const auto make = [](std::vector<Node> nodes) {
    std::vector<std::uint8_t> centres(nodes.size() * 32);
    return VocabularyTree(DescriptorKind::kOrb, 2, std::move(nodes), std::move(centres));
  };
  EXPECT_NO_THROW(make({{1, 2, 0}, {0, 0, 1}, {0, 0, 1}}));
  EXPECT_THROW(make({}), std::invalid_argument);
  EXPECT_THROW(make({{1, 3, 0}, {0, 0, 1}, {0, 0, 1}}), std::invalid_argument);   // past the end
  EXPECT_THROW(make({{1, 1, 0}, {0, 0, 1}, {0, 0, 1}}), std::invalid_argument);   // orphan
  EXPECT_THROW(make({{1, 2, 0}, {1, 1, 1}, {0, 0, 1}}), std::invalid_argument);   // cycle
  EXPECT_THROW(make({{1, 2, 0}, {0, 0, 2}, {0, 0, 1}}), std::invalid_argument);   // level
  EXPECT_THROW(make({{-1, 2, 0}, {0, 0, 1}, {0, 0, 1}}), std::invalid_argument);  // negative
}

}  // namespace nightmap::vocabulary_tree_test
