// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/match_descriptors.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/landmark_scene.h"

namespace nightmap::match_descriptors_test {

FrameFeatures Describe(const std::vector<std::vector<std::uint8_t>>& descriptors) {
  FrameFeatures features;
  for (const auto& descriptor : descriptors) {
    features.keypoints_px.emplace_back(0, 0);
    features.descriptors.insert(features.descriptors.end(), descriptor.begin(), descriptor.end());
  }
  return features;
}

std::vector<std::vector<std::uint8_t>> RandomDescriptors(int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::vector<std::uint8_t>> descriptors;
  for (int i = 0; i < count; ++i) descriptors.push_back(RandomRootSift(random));
  return descriptors;
}

// The same with every byte off by at most one.
std::vector<std::uint8_t> Disturbed(std::vector<std::uint8_t> descriptor, Random& random) {
  for (std::uint8_t& value : descriptor) {
    if (value > 0 && value < 255) {
      value = static_cast<std::uint8_t>(value - 1 + static_cast<int>(random.Index(3)));
    }
  }
  return descriptor;
}

TEST(MatchDescriptors, FindsEachDescriptorInAShuffledDisturbedCopy) {
  const auto descriptors = RandomDescriptors(100, 1);
  Random random(2);
  std::vector<std::vector<std::uint8_t>> shuffled;
  for (std::size_t i = 0; i < 100; ++i) {
    shuffled.push_back(Disturbed(descriptors[(i * 37) % 100], random));
  }
  const auto matches =
      MatchDescriptors(Describe(descriptors), Describe(shuffled), DescriptorKind::kRootSift, 0.8);
  ASSERT_EQ(matches.size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(matches[i].a, static_cast<int>(i));
    EXPECT_EQ((matches[i].b * 37) % 100, matches[i].a);
  }
}

// The ratio test looks from a to b alone; mutual nearest neighbours are symmetric.
TEST(MatchDescriptors, SwappingTheImagesSwapsTheMatches) {
  for (const auto kind : {DescriptorKind::kRootSift, DescriptorKind::kOrb}) {
    const auto size = static_cast<std::size_t>(DescriptorSize(kind));
    auto a = RandomDescriptors(80, 3), b = RandomDescriptors(60, 4);
    Random random(5);
    for (std::size_t i = 0; i < 30; ++i) b[i] = Disturbed(a[2 * i], random);
    for (auto* list : {&a, &b}) {
      for (auto& descriptor : *list) descriptor.resize(size);
    }
    const auto forward = MatchDescriptors(Describe(a), Describe(b), kind, 1.0);
    auto backward = MatchDescriptors(Describe(b), Describe(a), kind, 1.0);
    EXPECT_GE(forward.size(), 25U);
    for (FeatureMatch& match : backward) std::swap(match.a, match.b);
    std::ranges::sort(backward, {}, &FeatureMatch::a);
    EXPECT_EQ(forward, backward);
  }
}

TEST(MatchDescriptors, ARepeatedDescriptorFailsTheRatioTest) {
  auto descriptors = RandomDescriptors(20, 6);
  const FrameFeatures a = Describe(descriptors);
  descriptors.push_back(descriptors[4]);
  const auto matches = MatchDescriptors(a, Describe(descriptors), DescriptorKind::kRootSift, 0.8);
  EXPECT_EQ(matches.size(), 19U);
  for (const FeatureMatch& match : matches) EXPECT_NE(match.a, 4);
}

TEST(MatchDescriptors, AFeatureIsMatchedOnce) {
  Random random(7);
  const auto descriptors = RandomDescriptors(2, 8);
  // Both first features resemble the one in b; the nearer one gets it.
  const auto a = Describe({descriptors[0], Disturbed(descriptors[0], random), descriptors[1]});
  EXPECT_EQ(MatchDescriptors(a, Describe(descriptors), DescriptorKind::kRootSift, 0.8),
            (std::vector<FeatureMatch>{{0, 0}, {2, 1}}));
}

// The nearest of two is half as far as the other: as a length, and in bits.
TEST(MatchDescriptors, TheRatioIsOfDistances) {
  std::vector<std::uint8_t> origin(128, 0), near = origin, far = origin;
  near[0] = 30;
  far[1] = 60;
  std::vector<std::uint8_t> bits(32, 0), near_bits = bits, far_bits = bits;
  near_bits[3] = 0b0000'0101;
  far_bits[31] = 0b1000'0111;
  const auto num_matches = [](const auto& a, const auto& b, DescriptorKind kind, double max_ratio) {
    return MatchDescriptors(Describe({a}), Describe(b), kind, max_ratio).size();
  };
  const std::vector sift{far, near}, orb{far_bits, near_bits};
  EXPECT_EQ(num_matches(origin, sift, DescriptorKind::kRootSift, 0.51), 1U);
  EXPECT_EQ(num_matches(origin, sift, DescriptorKind::kRootSift, 0.49), 0U);
  EXPECT_EQ(num_matches(bits, orb, DescriptorKind::kOrb, 0.51), 1U);
  EXPECT_EQ(num_matches(bits, orb, DescriptorKind::kOrb, 0.49), 0U);
}

TEST(MatchDescriptors, NothingMatchesNothing) {
  const auto some = Describe(RandomDescriptors(5, 9));
  const FrameFeatures none;
  EXPECT_TRUE(MatchDescriptors(none, some, DescriptorKind::kRootSift, 0.8).empty());
  EXPECT_TRUE(MatchDescriptors(some, none, DescriptorKind::kRootSift, 0.8).empty());
  EXPECT_TRUE(MatchDescriptors(none, none, DescriptorKind::kRootSift, 0.8).empty());
}

}  // namespace nightmap::match_descriptors_test
