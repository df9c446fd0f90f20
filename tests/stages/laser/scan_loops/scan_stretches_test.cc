// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/scan_stretches.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>
#include <utility>

#include "tests/laser_building.h"

namespace nightmap::scan_stretches_test {

constexpr double kStep_m = 0.25;

// Each scan has hit the origin of the start and one point of its own.
std::vector<Keyscan> KeyscansOf(const std::vector<Rigid2>& poses) {
  std::vector<Keyscan> keyscans;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    keyscans.push_back({static_cast<std::int64_t>(i),
                        poses[i],
                        kStep_m * static_cast<double>(i),
                        {poses[i].Inverse() * Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0)},
                        {}});
  }
  return keyscans;
}

std::vector<Rigid2> Straight(int count) {
  std::vector<Rigid2> poses;
  for (int i = 0; i < count; ++i) poses.push_back({0.3, {kStep_m * i, 0}});
  return poses;
}

TEST(ScanStretches, SubmapsOverlapByHalf) {
  const auto keyscans = KeyscansOf(Straight(201));  // 50 m
  const auto submaps = CutSubmaps({}, keyscans);
  ASSERT_EQ(submaps.size(), 17U);  // at 0, 3 .. 48 m
  for (std::size_t i = 0; i < submaps.size(); ++i) {
    const auto& [first, middle, end] = submaps[i];
    EXPECT_EQ(keyscans[middle].path_m, 3.0 * static_cast<double>(i));
    EXPECT_EQ(keyscans[first].path_m, std::max(0.0, keyscans[middle].path_m - 3));
    EXPECT_EQ(keyscans[end - 1].path_m, std::min(50.0, keyscans[middle].path_m + 3 - kStep_m));
  }
}

TEST(ScanStretches, QueriesAreAboutTheirMiddle) {
  const auto keyscans = KeyscansOf(Straight(41));  // 10 m
  const auto queries = CutQueries({}, keyscans);
  ASSERT_EQ(queries.size(), 11U);
  EXPECT_EQ(queries[5].first, 16U);
  EXPECT_EQ(queries[5].middle, 20U);
  EXPECT_EQ(queries[5].end, 24U);
  ScanLoopsOptions options;
  options.query_length_m = 0;  // one scan
  for (const ScanStretch& query : CutQueries(options, keyscans)) {
    EXPECT_EQ(query.first, query.middle);
    EXPECT_EQ(query.end, query.middle + 1);
  }
}

TEST(ScanStretches, KeyscansFartherApartThanAStretchAreEachTheirOwn) {
  auto keyscans = KeyscansOf(Straight(5));
  for (Keyscan& keyscan : keyscans) keyscan.path_m *= 100;
  const auto submaps = CutSubmaps({}, keyscans);
  ASSERT_EQ(submaps.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(submaps[i].first, i);
    EXPECT_EQ(submaps[i].middle, i);
    EXPECT_EQ(submaps[i].end, i + 1);
  }
  EXPECT_TRUE(CutSubmaps({}, {}).empty());
}

TEST(ScanStretches, PointsAreInTheFrameOfTheMiddle) {
  const auto poses = DriveAround({3, 2}, 0.5, kStep_m, 1);
  const auto keyscans = KeyscansOf(poses);
  const auto points = PointsOf(keyscans, {10, 15, 30}).points;
  ASSERT_EQ(points.size(), 40U);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_LT((poses[15] * points[2 * i]).norm(), 1e-9);
    EXPECT_TRUE((poses[15] * points[2 * i + 1]).isApprox(poses[10 + i] * Eigen::Vector2d(1, 0)));
  }
}

// Two laps of 28 m around a ring, with little drift.
struct TwoLaps {
  std::vector<Rigid2> poses = DriveAround({4.5, 3.5}, 1, kStep_m, 2);
  std::vector<Keyscan> keyscans = KeyscansOf(poses);
  std::vector<ScanStretch> submaps, queries;
  ScanLoopsOptions options;

  std::vector<LoopPair> Pairs(double sigma_m) {
    submaps = CutSubmaps(options, keyscans);
    queries = CutQueries(options, keyscans);
    const auto edges = OdometryOf(poses, sigma_m, 1e-4).edges;
    return PairsToTry(options, keyscans, DriftSums(keyscans, edges), submaps, queries);
  }
  double Distance_m(const LoopPair& pair) const {
    return (poses[submaps[pair.submap].middle].translation -
            poses[queries[pair.query].middle].translation)
        .norm();
  }
};

TEST(ScanStretches, PairsAreNearInPlaceAndFarInPath) {
  TwoLaps laps;
  laps.options.max_distance_m = 2;
  const auto pairs = laps.Pairs(1e-6);
  ASSERT_GT(pairs.size(), 20U);
  std::map<std::size_t, std::vector<std::size_t>> submaps_of;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const LoopPair& pair = pairs[i];
    EXPECT_LT(laps.Distance_m(pair), 2 + 1e-3);
    const std::size_t last = laps.submaps[pair.submap].end - 1;
    EXPECT_GE(laps.keyscans[laps.queries[pair.query].middle].path_m,
              laps.keyscans[last].path_m + laps.options.min_path_m);
    if (i > 0) {
      EXPECT_LT(std::pair(pairs[i - 1].submap, pairs[i - 1].query),
                std::pair(pair.submap, pair.query));
    }
    for (const std::size_t other : submaps_of[pair.query]) {
      EXPECT_GT(std::max(other, pair.submap) - std::min(other, pair.submap), 1U);
    }
    submaps_of[pair.query].push_back(pair.submap);
  }
  // Each place of the second lap has been seen, but those whose submap begins near its start.
  for (std::size_t query = 0; query < laps.queries.size(); ++query) {
    const double path_m = laps.keyscans[laps.queries[query].middle].path_m;
    if (path_m > 32) {
      EXPECT_EQ(submaps_of.count(query), 1U) << path_m;
    }
  }
}

TEST(ScanStretches, AQueryTriesTheNearestSubmapsFirst) {
  TwoLaps laps;
  laps.options.max_distance_m = 100;
  laps.options.max_candidates = 1;
  const auto pairs = laps.Pairs(1e-6);
  std::map<std::size_t, double> distance_of;
  for (const LoopPair& pair : pairs) {
    EXPECT_TRUE(distance_of.emplace(pair.query, laps.Distance_m(pair)).second);
  }
  laps.options.max_candidates = 3;
  const auto more = laps.Pairs(1e-6);
  EXPECT_GT(more.size(), 2 * pairs.size());
  std::map<std::size_t, int> num_of;
  for (const LoopPair& pair : more) {
    EXPECT_GE(laps.Distance_m(pair), distance_of.at(pair.query) - 1e-9);
    EXPECT_LE(++num_of[pair.query], 3);
  }
}

TEST(ScanStretches, DriftLetsAQueryBeFartherAway) {
  TwoLaps laps;
  laps.options.max_distance_m = 0.5;
  const std::size_t num_without = laps.Pairs(1e-6).size();
  EXPECT_GT(laps.Pairs(0.1).size(), num_without);  // 1 m and more over 100 keyscans
}

// Half way, the robot was carried: no drift limits where it may be then.
TEST(ScanStretches, AfterAnUnknownMotionSomeQueriesTryAllSubmapsBefore) {
  TwoLaps laps;
  laps.options.max_distance_m = 0.5;
  const std::vector<ScanStretch> submaps = CutSubmaps(laps.options, laps.keyscans);
  const std::vector<ScanStretch> queries = CutQueries(laps.options, laps.keyscans);
  auto edges = OdometryOf(laps.poses, 1e-6, 1e-4).edges;
  const std::size_t carried = edges.size() / 2;
  edges[carried].covariance = 9 * Matrix6d::Identity();
  const auto pairs =
      PairsToTry(laps.options, laps.keyscans, DriftSums(laps.keyscans, edges), submaps, queries);
  std::map<std::size_t, std::size_t> num_before;
  for (const LoopPair& pair : pairs) {
    const bool is_across =
        submaps[pair.submap].middle <= carried && queries[pair.query].middle > carried;
    EXPECT_EQ(pair.drift.IsUnknown(), is_across);
    if (is_across) ++num_before[pair.query];
  }
  ASSERT_GT(num_before.size(), 3U);
  EXPECT_LT(num_before.size(), queries.size() / 4);
  for (const auto& [query, num] : num_before) EXPECT_GE(num, 3U) << query;
}

// Goes through all submaps for each query.
std::vector<std::pair<std::size_t, std::size_t>> PairsOneByOne(const TwoLaps& laps,
                                                               const DriftSums& drifts) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t query = 0; query < laps.queries.size(); ++query) {
    const Keyscan& sought = laps.keyscans[laps.queries[query].middle];
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t i = 0; i < laps.submaps.size(); ++i) {
      const ScanStretch& submap = laps.submaps[i];
      if (laps.keyscans[submap.end - 1].path_m + laps.options.min_path_m > sought.path_m) continue;
      const Drift drift = drifts.Between(submap.middle, laps.queries[query].middle);
      const double apart_m = (laps.keyscans[submap.middle].start_from_robot.translation -
                              sought.start_from_robot.translation)
                                 .norm();
      if (drift.IsUnknown()) {
        if (query % kUnknownSpacing == 0 && i % 2 == 0) pairs.emplace_back(i, query);
      } else if (apart_m - 3 * drift.Sigma_m() <= laps.options.max_distance_m) {
        near.emplace_back(apart_m, i);
      }
    }
    std::ranges::sort(near);
    std::vector<std::size_t> chosen;
    for (const auto& [apart_m, i] : near) {
      const bool overlaps = std::ranges::any_of(
          chosen, [i = i](std::size_t other) { return other + 1 >= i && other <= i + 1; });
      if (overlaps || std::ssize(chosen) == laps.options.max_candidates) continue;
      chosen.push_back(i);
      pairs.emplace_back(i, query);
    }
  }
  std::ranges::sort(pairs);
  return pairs;
}

TEST(ScanStretches, PairsAreThoseOfASearchOfAllSubmaps) {
  for (const double sigma_m : {1e-6, 0.02, 0.3}) {
    for (const bool is_carried : {false, true}) {
      TwoLaps laps;
      laps.poses = DriveAround({14, 3.5}, 1, kStep_m, 3);
      laps.keyscans = KeyscansOf(laps.poses);
      laps.options.max_distance_m = 3;
      laps.submaps = CutSubmaps(laps.options, laps.keyscans);
      laps.queries = CutQueries(laps.options, laps.keyscans);
      auto edges = OdometryOf(laps.poses, sigma_m, 2e-3).edges;
      if (is_carried) edges[edges.size() / 2].covariance = 9 * Matrix6d::Identity();
      const DriftSums drifts(laps.keyscans, edges);
      std::vector<std::pair<std::size_t, std::size_t>> pairs;
      for (const LoopPair& pair :
           PairsToTry(laps.options, laps.keyscans, drifts, laps.submaps, laps.queries)) {
        pairs.emplace_back(pair.submap, pair.query);
      }
      EXPECT_EQ(pairs, PairsOneByOne(laps, drifts)) << sigma_m << is_carried;
      EXPECT_GT(pairs.size(), 30U);
    }
  }
}

}  // namespace nightmap::scan_stretches_test
