// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/clusters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

namespace nightmap::clusters_test {

// Voxels by class, in the order of the format.
class VoxelBoxes {
 public:
  VoxelBoxes& Add(std::uint8_t label, const VoxelBox& box, float share = 1) {
    for (VoxelKey key = box.min; key.z() < box.max.z(); ++key.z()) {
      for (key.y() = box.min.y(); key.y() < box.max.y(); ++key.y()) {
        for (key.x() = box.min.x(); key.x() < box.max.x(); ++key.x()) {
          votes_[MortonCode(key)] = {label, share};
        }
      }
    }
    return *this;
  }

  VoxelLabels Labels() const {
    VoxelLabels voxels;
    voxels.resolution_m = 0.05;
    voxels.classes = {"none", "sofa", "table"};
    for (const auto& [code, vote] : votes_) {
      voxels.keys.push_back(KeyOfMortonCode(code));
      voxels.num_views.push_back(1);
      if (vote.second < 1) {
        voxels.vote_labels.push_back(0);
        voxels.vote_weights.push_back((1 - vote.second) / 2);
      }
      voxels.vote_labels.push_back(vote.first);
      voxels.vote_weights.push_back(vote.second);
      if (vote.second < 1) {
        voxels.vote_labels.push_back(3);
        voxels.vote_weights.push_back((1 - vote.second) / 2);
      }
      voxels.vote_offsets.push_back(voxels.vote_labels.size());
    }
    voxels.classes.push_back("lamp");
    return voxels;
  }

 private:
  std::map<std::uint64_t, std::pair<std::uint8_t, float>> votes_;
};

const ClusterOptions kOptions{{1, 2}, 0.5, 1.8, 20};

std::vector<std::size_t> Sizes(const std::vector<Cluster>& clusters) {
  std::vector<std::size_t> sizes;
  for (const Cluster& cluster : clusters) sizes.push_back(cluster.voxels.size());
  return sizes;
}

VoxelBox BoxAt(int x, int size = 4) { return {{x, -2, 0}, {x + size, 2, 4}}; }

TEST(FindClusters, BoxesApartAreTwoThings) {
  const auto apart = VoxelBoxes().Add(1, BoxAt(-4)).Add(1, BoxAt(1)).Labels();
  EXPECT_THAT(Sizes(FindClusters(kOptions, apart, 1)), testing::ElementsAre(64, 64));
  const auto touching = VoxelBoxes().Add(1, BoxAt(-4)).Add(1, BoxAt(0)).Labels();
  EXPECT_THAT(Sizes(FindClusters(kOptions, touching, 1)), testing::ElementsAre(128));
}

TEST(FindClusters, CornersTouchAndATolerationJoins) {
  const auto voxels = VoxelBoxes().Add(1, {{0, 0, 0}, {4, 4, 4}}).Add(1, {{4, 4, 4}, {8, 8, 8}});
  EXPECT_THAT(Sizes(FindClusters(kOptions, voxels.Labels(), 1)), testing::ElementsAre(128));
  ClusterOptions options = kOptions;
  options.tolerance_voxels = 2.1;
  const auto apart = VoxelBoxes().Add(1, BoxAt(-4)).Add(1, BoxAt(1)).Labels();
  EXPECT_THAT(Sizes(FindClusters(options, apart, 1)), testing::ElementsAre(128));
}

TEST(FindClusters, TouchingBoxesOfTwoClassesAreTwoThings) {
  const auto voxels = VoxelBoxes().Add(2, BoxAt(-4)).Add(1, BoxAt(0)).Labels();
  const auto clusters = FindClusters(kOptions, voxels, 1);
  ASSERT_EQ(clusters.size(), 2U);
  EXPECT_EQ(clusters[0].label, 1);  // in order of class
  EXPECT_EQ(clusters[1].label, 2);
}

TEST(FindClusters, SmallOnesAndOtherClassesAreLeftOut) {
  const auto voxels =
      VoxelBoxes().Add(1, {{0, 0, 0}, {19, 1, 1}}).Add(0, BoxAt(40)).Add(2, BoxAt(60)).Labels();
  ASSERT_THAT(Sizes(FindClusters(kOptions, voxels, 1)), testing::ElementsAre(64));
  ClusterOptions options = kOptions;
  options.min_voxels = 19;
  EXPECT_THAT(Sizes(FindClusters(options, voxels, 1)), testing::ElementsAre(19, 64));
  options.labels = {1};
  EXPECT_THAT(Sizes(FindClusters(options, voxels, 1)), testing::ElementsAre(19));
}

TEST(FindClusters, VoxelsOfWhichVotesDisagreeDoNotCount) {
  const auto voxels = VoxelBoxes().Add(1, BoxAt(-4), 0.75F).Add(1, BoxAt(0), 0.4F).Labels();
  const auto clusters = FindClusters(kOptions, voxels, 1);
  ASSERT_THAT(Sizes(clusters), testing::ElementsAre(64));
  EXPECT_NEAR(clusters[0].mean_share, 0.75, 1e-6);
}

TEST(FindClusters, SameAtAnyNumberOfThreads) {
  VoxelBoxes boxes;
  for (int i = 0; i < 30; ++i) {
    boxes.Add(static_cast<std::uint8_t>(1 + i % 2), BoxAt(7 * (i * 11 % 30) - 90, 3 + i % 3));
  }
  const auto one = FindClusters(kOptions, boxes.Labels(), 1);
  const auto four = FindClusters(kOptions, boxes.Labels(), 4);
  ASSERT_EQ(one.size(), 30U);
  ASSERT_EQ(four.size(), 30U);
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].voxels, four[i].voxels);
}

}  // namespace nightmap::clusters_test
