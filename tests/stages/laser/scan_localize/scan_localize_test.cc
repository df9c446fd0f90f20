// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/scan_localize.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "stages/laser/scan_localize/located_output.h"
#include "tests/stages/laser/scan_localize/scan_world.h"
#include "tests/test_data.h"

namespace nightmap::scan_localize_test {

const OccupancyGrid& RoomsMap() {
  static const OccupancyGrid map = MapOf(kRooms, PlacesIn(kRooms, 1));
  return map;
}

std::vector<LocatedScan> LocateAll(const ScanLocalizeInput& input,
                                   const ScanLocalizeOptions& options = {},
                                   int num_threads = 2) {
  Progress progress("scan_localize", false);
  return RunScanLocalize(options, input, progress, num_threads);
}

std::ptrdiff_t CountOf(const std::vector<LocatedScan>& located, QueryVerdict verdict) {
  return std::ranges::count(
      located, verdict, [](const LocatedScan& scan) { return scan.result.verdict; });
}

TEST(ScanLocalize, FindsScansInTheWholeMapWhateverTheirHeading) {
  const AskedScans asked = AskAt(kRooms, 60, 1);
  const auto located = LocateAll({RoomsMap(), asked.queries, {}});
  ASSERT_EQ(located.size(), asked.queries.size());
  EXPECT_GE(CountOf(located, QueryVerdict::kLocated), 57);
  for (std::size_t i = 0; i < located.size(); ++i) {
    const QueryResult& result = located[i].result;
    EXPECT_EQ(result.query_idx, static_cast<int>(i));
    EXPECT_EQ(result.color_path, asked.queries[i].name);
    EXPECT_EQ(result.time_ns, asked.queries[i].time_ns);
    if (!result.IsLocated()) continue;
    EXPECT_LT(Distance_m(result, asked.poses[i]), 0.06) << i;
    EXPECT_LT(Turn_deg(result, asked.poses[i]), 1) << i;
    EXPECT_GT(result.position_sigma_m, 0);
    EXPECT_LT(Distance_m(result, asked.poses[i]), 6 * result.position_sigma_m + 0.01) << i;
    EXPECT_GT(result.num_inliers, result.num_matches / 2);
  }
}

TEST(ScanLocalize, TheMapMayBeTurned) {
  OccupancyGrid turned = RoomsMap();
  turned.origin_yaw_rad = 0.7;
  turned.origin_in_map = Eigen::Rotation2Dd(0.7) * turned.origin_in_map;
  const AskedScans asked = AskAt(kRooms, 10, 2);
  const auto located = LocateAll({turned, asked.queries, {}});
  const Rigid2 turned_from_map{0.7, {0, 0}};
  for (std::size_t i = 0; i < located.size(); ++i) {
    ASSERT_TRUE(located[i].result.IsLocated()) << i;
    EXPECT_LT(Distance_m(located[i].result, turned_from_map * asked.poses[i]), 0.08) << i;
  }
}

TEST(ScanLocalize, ATurnOfTheRobotIsOneQuery) {
  const Rigid2 pose{0.4, {5, -2}};
  ScanQuery turn = QueryAt(kRooms, pose, 0);
  for (const double turn_rad : {1.5, 3.0, 4.5}) {
    const Rigid2 query_from_laser{turn_rad, {0.05, 0}};
    turn.scans.push_back(QueryAt(kRooms, pose * query_from_laser, 0).scans[0]);
    turn.scans.back().query_from_laser = query_from_laser;
  }
  const auto located = LocateAll({RoomsMap(), {turn}, {}});
  ASSERT_TRUE(located[0].result.IsLocated());
  EXPECT_LT(Distance_m(located[0].result, pose), 0.05);
}

TEST(ScanLocalize, AScanOfAnotherBuildingIsNotInTheMap) {
  const Building other = {{{-4, -3}, {3, 4}},
                          {{0, 0}, {1.4, 1}},
                          {{-4, 2}, {-3, 4}},
                          {{-2, -3}, {-1.5, -1}},
                          {{2, -1.5}, {2.4, -1}}};
  const AskedScans asked = AskAt(other, 40, 3);
  const auto located = LocateAll({RoomsMap(), asked.queries, {}});
  EXPECT_GE(CountOf(located, QueryVerdict::kNotInMap), 38);
  EXPECT_EQ(CountOf(located, QueryVerdict::kLocated), 0);
}

TEST(ScanLocalize, AScanOfAPlainRoomFitsTwoWays) {
  const Building square = {{{-4, -4}, {4, 4}}, {{-4, -4.1}, {-3.9, -4}}};
  const AskedScans asked = AskAt(square, 10, 4);
  const auto located = LocateAll({MapOf(square, PlacesIn(square, 1)), asked.queries, {}});
  EXPECT_EQ(CountOf(located, QueryVerdict::kAmbiguous), 10);
  for (const LocatedScan& scan : located) {
    EXPECT_EQ(scan.result.reason, "rival_place");
    EXPECT_GE(scan.candidates.size(), 2U);
  }
}

TEST(ScanLocalize, ARoughPositionDecidesBetweenPlacesThatLookAlike) {
  const Building square = {{{-4, -4}, {4, 4}}, {{-4, -4.1}, {-3.9, -4}}};
  AskedScans asked = AskAt(square, 10, 4);
  int num_inside = 0;
  for (std::size_t i = 0; i < asked.queries.size(); ++i) {
    asked.queries[i].rough_position = RoughPosition{asked.poses[i].translation, 0.8};
  }
  const auto located = LocateAll({MapOf(square, PlacesIn(square, 1)), asked.queries, {}});
  for (std::size_t i = 0; i < located.size(); ++i) {
    for (const ScanCandidate& candidate : located[i].candidates) {
      const double off_m =
          (candidate.map_from_query.translation - asked.poses[i].translation).norm();
      EXPECT_LT(off_m, 0.8 * std::numbers::sqrt2 + 0.3);
    }
    num_inside += located[i].result.IsLocated();
  }
  EXPECT_GE(num_inside, 6);
}

TEST(ScanLocalize, ARadiusBeyondTheMapSearchesTheMapAndNoMore) {
  AskedScans asked = AskAt(kRooms, 5, 9);
  for (ScanQuery& query : asked.queries) query.rough_position = RoughPosition{{5, 0}, 1e6};
  ScanLocalizeOptions published;
  published.method = "published";
  for (const LocatedScan& scan : LocateAll({RoomsMap(), asked.queries, {}}, published)) {
    EXPECT_FALSE(scan.candidates.empty());
  }
  const auto located = LocateAll({RoomsMap(), asked.queries, {}});
  for (std::size_t i = 0; i < located.size(); ++i) {
    ASSERT_FALSE(located[i].candidates.empty());
    const Rigid2& best = located[i].candidates.front().map_from_query;
    EXPECT_LT((best.translation - asked.poses[i].translation).norm(), 0.1) << i;
  }
}

TEST(ScanLocalize, MovedFurnitureDoesNotDragThePose) {
  Building changed = kRooms;
  changed[3] = {{3.4, -6}, {5.4, -4.5}};  // 0.4 m along the wall
  changed.push_back({{7, -3}, {8, -2}});
  const AskedScans asked = AskAt(changed, 40, 5);
  const auto located = LocateAll({RoomsMap(), asked.queries, {}});
  EXPECT_GE(CountOf(located, QueryVerdict::kLocated), 36);
  for (std::size_t i = 0; i < located.size(); ++i) {
    if (!located[i].result.IsLocated()) continue;
    EXPECT_LT(Distance_m(located[i].result, asked.poses[i]), 0.08) << i;
  }
}

// Two equal rooms with a column each; the map has forgotten one of them, which an object marks.
TEST(ScanLocalize, AnObjectThatABeamPassesThroughRefusesThePlace) {
  const Building alike = {{{-8, -4}, {8, 4}},
                          {{-0.2, -4}, {0.2, 4}},
                          {{-6, 1}, {-5, 1.6}},
                          {{2.4, 1}, {3.4, 1.6}},
                          {{-3.2, -2}, {-2.9, -1.7}}};
  const auto places = PlacesIn(alike, 1);
  const OccupancyGrid map = MapOf(alike, places);
  const MapObject column{"column", {0, {-3.05, -1.85}}, {0.8, 0.8}, {}};
  const auto walls = WallsOfObjects(map, {column});
  ASSERT_GT(walls.size(), 5U);
  const Rigid2 right{-2.2, {5, 0}}, wrong{-2.2, {-3.4, 0}};  // the same view in the other room
  const ScanQuery query = QueryAt(alike, right, 0);
  EXPECT_GT(ViewObjects(walls, query, wrong, 30).num_contradicted, 3);
  EXPECT_EQ(ViewObjects(walls, query, wrong, 30).num_confirmed, 0);
  const ScanQuery there = QueryAt(alike, wrong, 0);
  const ObjectView view = ViewObjects(walls, there, wrong, 30);
  EXPECT_GT(view.num_confirmed, 3);
  EXPECT_LE(view.num_contradicted, view.num_confirmed);  // beams pass close by its corners
  const auto without = LocateAll({map, {query}, {}});
  const auto with = LocateAll({map, {query}, {column}});
  const auto fit_of_wrong = [&](const std::vector<LocatedScan>& located) {
    for (const ScanCandidate& candidate : located[0].candidates) {
      if (IsSamePlace(candidate.map_from_query, wrong)) return candidate.fit;
    }
    return 0.0;
  };
  EXPECT_GT(fit_of_wrong(without), 0.5);
  EXPECT_LT(fit_of_wrong(with), fit_of_wrong(without) - 0.02);
  EXPECT_LT(Distance_m(with[0].result, right), 0.1);
}

TEST(ScanLocalize, AScanThatSawNextToNothingHasNoFeatures) {
  ScanQuery query = QueryAt(kRooms, {0, {5, 0}}, 0);
  for (std::size_t i = 15; i < query.scans[0].ranges_m.size(); ++i) query.scans[0].ranges_m[i] = 0;
  ScanQuery nothing{"nothing", 2'000'000'000, {}, {}};
  const auto located = LocateAll({RoomsMap(), {query, nothing}, {}});
  for (const LocatedScan& scan : located) {
    EXPECT_EQ(scan.result.verdict, QueryVerdict::kNoFeatures);
    EXPECT_EQ(scan.result.reason, "too_few_points");
  }
}

TEST(ScanLocalize, AMapWithoutWallsIsAnErrorWithItsRemedy) {
  OccupancyGrid empty = RoomsMap();
  std::ranges::replace(empty.cells, static_cast<std::uint8_t>(kOccupiedCell), kFreeCell);
  NIGHTMAP_EXPECT_ERROR(DataError, LocateAll({empty, {}, {}}), "check the job that made it");
}

TEST(ScanLocalize, TheSameBytesAtAnyNumberOfThreads) {
  const AskedScans asked = AskAt(kRooms, 12, 6);
  const ScanLocalizeInput input{RoomsMap(), asked.queries, {}};
  const auto one = LocateAll(input, {}, 1), four = LocateAll(input, {}, 4);
  EXPECT_EQ(CandidatesToCsv(one), CandidatesToCsv(four));
  EXPECT_EQ(SummarizeScans(one).dump(), SummarizeScans(four).dump());
}

TEST(ScanLocalize, CandidatesAreApartAndInTheOrderOfTheirFit) {
  const AskedScans asked = AskAt(kRooms, 10, 8);
  ScanLocalizeOptions options;
  options.candidates.min_share_of_best = 0.6;
  for (const LocatedScan& scan : LocateAll({RoomsMap(), asked.queries, {}}, options)) {
    const auto& all = scan.candidates;
    EXPECT_TRUE(std::ranges::is_sorted(all, std::greater(), &ScanCandidate::fit));
    for (std::size_t i = 0; i < all.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        EXPECT_FALSE(IsSamePlace(all[i].map_from_query, all[k].map_from_query));
      }
    }
  }
}

}  // namespace nightmap::scan_localize_test
