// SPDX-License-Identifier: Apache-2.0
// scan_localize in a building whose two wings are the same room, furniture included: a scan that
// fits both is ambiguous, and none is located in the wrong one.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "stages/laser/scan_localize/scan_localize.h"
#include "tests/stages/laser/scan_localize/scan_world.h"

namespace nightmap::two_wings_test {

constexpr std::size_t kNumScans = 240;
constexpr double kWest_m = -14;  // where the western wing begins; it is 8 m wide

// The eastern wing is the western one, shifted_m farther along the corridor in the south.
struct Wings {
  double shifted_m = 20;
  Building building;

  explicit Wings(double shift_m, const std::vector<Box2>& only_in_west = {}) : shifted_m(shift_m) {
    building = {{{-16, -6}, {16.5, 6}},
                {{-16, -4}, {kWest_m, 6}},
                {{kWest_m + 8, -4}, {kWest_m + shifted_m, 6}},
                {{kWest_m + shifted_m + 8, -4}, {16.5, 6}}};
    for (const double wing_m : {0.0, shifted_m}) {
      const Eigen::Vector2d corner(kWest_m + wing_m, 0);
      for (const Box2& box : std::vector<Box2>{{{0, -4}, {3, -3.8}},  // a door 1 m wide is between
                                               {{4, -4}, {8, -3.8}},
                                               {{4, 1}, {4.2, 6}},
                                               {{0, 4}, {1.5, 6}},
                                               {{1.5, -1}, {2.6, -0.2}},
                                               {{6, -3.8}, {8, -3}},
                                               {{6.2, 2}, {6.6, 2.4}}}) {
        building.push_back({corner + box.low, corner + box.high});
      }
    }
    building.insert(building.end(), only_in_west.begin(), only_in_west.end());
  }

  bool IsInWest(const Eigen::Vector2d& point) const { return point.x() < kWest_m + shifted_m / 2; }
  // The same view in the other wing.
  Rigid2 Other(const Rigid2& pose) const {
    const double shift_m = IsInWest(pose.translation) ? shifted_m : -shifted_m;
    return {pose.heading_rad, pose.translation + Eigen::Vector2d(shift_m, 0)};
  }
};

// A column in the western wing only.
const Box2 kColumn{{kWest_m + 5.2, -1.6}, {kWest_m + 5.7, -1.1}};
const MapObject kColumnObject{"column", {0, {kWest_m + 5.45, -1.35}}, {0.8, 0.8}, {}};

AskedScans AskInWings(const Wings& wings, std::uint64_t seed) {
  Random random(seed);
  AskedScans asked;
  while (asked.poses.size() < kNumScans) {
    const double shift_m = asked.poses.size() % 2 == 0 ? 0 : wings.shifted_m;
    const Rigid2 pose{random.Uniform(-std::numbers::pi, std::numbers::pi),
                      {kWest_m + shift_m + random.Uniform(0, 8), random.Uniform(-3.8, 6)}};
    if (!IsInside(wings.building, pose.translation, 0.3)) continue;
    asked.queries.push_back(QueryAt(wings.building, pose, asked.poses.size()));
    asked.poses.push_back(pose);
  }
  return asked;
}

// The beams that tell a pose from the same view in the other wing.
int NumTellingBeams(const Wings& wings, const Rigid2& pose) {
  constexpr double kDegree_rad = std::numbers::pi / 180;
  const Rigid2 other = wings.Other(pose);
  int num_telling = 0;
  for (int beam = 0; beam < 360; ++beam) {
    const double heading_rad = beam * kDegree_rad;
    const double range_m = RangeToWall_m(wings.building, pose.translation, heading_rad);
    const double other_m = RangeToWall_m(wings.building, other.translation, heading_rad);
    num_telling += std::abs(range_m - other_m) > 0.3;
  }
  return num_telling;
}

std::string Describe(const Rigid2& pose, const std::vector<ScanCandidate>& candidates) {
  std::string text =
      fmt::format("\n  at {:.2f} {:.2f}", pose.translation.x(), pose.translation.y());
  for (const ScanCandidate& candidate : candidates) {
    text += fmt::format("; found {:.2f} {:.2f} fit {:.3f} search {:.3f} objects {}/{}",
                        candidate.map_from_query.translation.x(),
                        candidate.map_from_query.translation.y(),
                        candidate.fit,
                        candidate.search_score,
                        candidate.objects.num_confirmed,
                        candidate.objects.num_contradicted);
  }
  return text;
}

struct Outcome {
  int num_located = 0, num_ambiguous = 0;
  int num_telling = 0, num_telling_located = 0;  // those with enough beams that tell
  int num_wrong = 0;                             // located in the wrong wing
  int num_off = 0;                               // located in the right one, but 0.1 m off
  std::string wrong;                             // these, described
};

Outcome Locate(const Wings& wings,
               const AskedScans& asked,
               const std::vector<MapObject>& objects = {}) {
  constexpr int kMinTelling = 20;
  Progress progress("scan_localize", false);
  const OccupancyGrid map = MapOf(wings.building, PlacesIn(wings.building, 1));
  const auto located = RunScanLocalize({}, {map, asked.queries, objects}, progress, 2);
  Outcome outcome;
  for (std::size_t i = 0; i < located.size(); ++i) {
    const QueryResult& result = located[i].result;
    const bool is_telling = NumTellingBeams(wings, asked.poses[i]) >= kMinTelling;
    outcome.num_telling += is_telling;
    outcome.num_ambiguous += result.verdict == QueryVerdict::kAmbiguous;
    if (!result.IsLocated()) continue;
    ++outcome.num_located;
    outcome.num_telling_located += is_telling;
    const Eigen::Vector2d found = result.map_from_camera.translation.head<2>();
    const bool is_wrong = wings.IsInWest(found) != wings.IsInWest(asked.poses[i].translation);
    outcome.num_wrong += is_wrong;
    outcome.num_off += !is_wrong && Distance_m(result, asked.poses[i]) > 0.1;
    if (is_wrong) outcome.wrong += Describe(asked.poses[i], located[i].candidates);
  }
  ::testing::Test::RecordProperty("num_located", outcome.num_located);
  ::testing::Test::RecordProperty("num_ambiguous", outcome.num_ambiguous);
  ::testing::Test::RecordProperty("num_telling", outcome.num_telling);
  ::testing::Test::RecordProperty("num_telling_located", outcome.num_telling_located);
  ::testing::Test::RecordProperty("num_wrong", outcome.num_wrong);
  return outcome;
}

void ExpectNoneWrong(const Outcome& outcome) {
  EXPECT_EQ(outcome.num_wrong, 0) << outcome.wrong;
  EXPECT_EQ(outcome.num_off, 0);
}

TEST(TwoWings, AScanThatFitsBothIsAmbiguous) {
  const Wings wings(20);
  const Outcome outcome = Locate(wings, AskInWings(wings, 11));
  ExpectNoneWrong(outcome);
  EXPECT_GE(outcome.num_ambiguous, 0.95 * kNumScans);
}

// The walls of the two wings lie elsewhere in their cells, so that the grid draws them differently.
TEST(TwoWings, TheCellsOfTheGridDoNotTellTheWingsApart) {
  const Wings wings(20.02);
  const Outcome outcome = Locate(wings, AskInWings(wings, 11));
  ExpectNoneWrong(outcome);
  EXPECT_GE(outcome.num_ambiguous, 0.95 * kNumScans);
}

TEST(TwoWings, AColumnInOneWingMisleadsNone) {
  const Wings wings(20, {kColumn});
  ExpectNoneWrong(Locate(wings, AskInWings(wings, 11)));
}

TEST(TwoWings, AColumnThatIsAnObjectTellsTheWingsApart) {
  const Wings wings(20, {kColumn});
  const Outcome outcome = Locate(wings, AskInWings(wings, 11), {kColumnObject});
  ExpectNoneWrong(outcome);
  EXPECT_GE(outcome.num_telling, 20);
  EXPECT_GE(outcome.num_telling_located, 0.8 * outcome.num_telling);
}

TEST(TwoWings, ARoughPositionTellsTheWingsApart) {
  const Wings wings(20.02);
  AskedScans asked = AskInWings(wings, 11);
  for (std::size_t i = 0; i < kNumScans; ++i) {
    const Eigen::Vector2d near = asked.poses[i].translation + Eigen::Vector2d(0.7, -0.7);
    asked.queries[i].rough_position = RoughPosition{near, 2};
  }
  const Outcome outcome = Locate(wings, asked);
  ExpectNoneWrong(outcome);
  EXPECT_GE(outcome.num_located, 0.95 * kNumScans);
}

}  // namespace nightmap::two_wings_test
