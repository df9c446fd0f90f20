// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/scan_pairs.h"

#include <gmock/gmock.h>

#include <set>
#include <utility>

#include "tests/laser_building.h"

namespace nightmap::scan_pairs_test {

using Pairs = std::set<std::pair<std::size_t, std::size_t>>;

Pairs PairsOf(const std::vector<Rigid2>& poses, const ScanAdjustOptions& options = {}) {
  Pairs pairs;
  for (const ScanPair& pair : ChoosePairs(options, poses)) {
    EXPECT_TRUE(pairs.emplace(pair.scan, pair.target).second) << "twice";
  }
  return pairs;
}

TEST(ScanPairs, EachScanWithThoseBeforeItAtGrowingDistancesBothWays) {
  std::vector<Rigid2> poses;
  for (int i = 0; i < 20; ++i) poses.push_back({0, {0.2 * i, 0}});
  const Pairs pairs = PairsOf(poses);
  Pairs expected;
  for (std::size_t scan = 0; scan < 20; ++scan) {
    for (const std::size_t back : {1, 2, 4, 8}) {
      if (back > scan) continue;
      expected.emplace(scan, scan - back);
      expected.emplace(scan - back, scan);
    }
  }
  EXPECT_EQ(pairs, expected);
}

TEST(ScanPairs, NotWithThoseThatAreTooFarAwayOrTurnedTooMuch) {
  const ScanAdjustOptions options;
  EXPECT_TRUE(PairsOf({{0, {0, 0}}, {0, {3.1, 0}}}, options).empty());
  EXPECT_TRUE(PairsOf({{0, {0, 0}}, {1.2, {1.9, 0}}}, options).empty());
  EXPECT_EQ(PairsOf({{0, {0, 0}}, {0, {2.9, 0}}}, options).size(), 2U);
  EXPECT_EQ(PairsOf({{0, {0, 0}}, {3.1, {0, 0}}}, options).size(), 0U);
  // A turn the short way round.
  EXPECT_EQ(PairsOf({{3.1, {0, 0}}, {-3.1, {0, 0}}}, options).size(), 2U);
  EXPECT_TRUE(PairsOf({}).empty());
  EXPECT_TRUE(PairsOf({Rigid2{}}).empty());
}

TEST(ScanPairs, OfOtherTimesTheNearest) {
  const std::vector<Rigid2> poses = DriveAround({4, 3}, 1, 0.25, 2);
  ScanAdjustOptions options;
  options.num_near_in_time = 1;
  std::vector<double> paths_m{0};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    paths_m.push_back(paths_m.back() + (poses[i].translation - poses[i - 1].translation).norm());
  }
  const auto apart = [&](std::size_t a, std::size_t b) {
    return (poses[a].translation - poses[b].translation).norm() +
           std::abs(WrapAngle_rad(poses[a].heading_rad - poses[b].heading_rad));
  };
  const Pairs pairs = PairsOf(poses, options);
  for (std::size_t scan = 0; scan < poses.size(); ++scan) {
    std::vector<double> expected, found;
    for (std::size_t target = 0; target < poses.size(); ++target) {
      if (std::abs(paths_m[scan] - paths_m[target]) < kOtherTime_m) continue;
      if (apart(scan, target) <= 3) expected.push_back(apart(scan, target));
      if (pairs.contains({scan, target})) found.push_back(apart(scan, target));
    }
    std::ranges::sort(expected);
    std::ranges::sort(found);
    expected.resize(std::min<std::size_t>(6, expected.size()));
    EXPECT_THAT(found, testing::Pointwise(testing::DoubleNear(1e-9), expected)) << scan;
  }
  options.num_of_other_times = 0;
  EXPECT_EQ(PairsOf(poses, options).size(), 2 * (poses.size() - 1));
}

}  // namespace nightmap::scan_pairs_test
