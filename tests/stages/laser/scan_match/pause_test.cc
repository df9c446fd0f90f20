// SPDX-License-Identifier: Apache-2.0
// scan_match after minutes without a scan.
#include <algorithm>
#include <cmath>

#include "stages/laser/scan_match/scan_match.h"
#include "tests/laser_building.h"
#include "tests/test_data.h"

namespace nightmap::pause_test {

// A hall in the shape of an L, which fits to itself at no other place, and a room that the hall's
// scans cannot see.
const Building kHall{{{-6, -4}, {6, 4}}, {{-7, 1}, {-1, 5}}, {{2, -3.3}, {2.5, -2.6}}};
const Building kOther{{{-3, -3}, {4, 2}}, {{1, -1}, {2.2, -0.6}}};
constexpr std::int64_t kPause_ns = 780'000'000'000;

std::vector<Rigid2> Straight(const Rigid2& start, int num) {
  std::vector<Rigid2> poses;
  for (int i = 0; i < num; ++i) poses.push_back(start * Rigid2{0, {0.1 * i, 0}});
  return poses;
}

// The scans of a drive, then, after a pause, those of another one.
ScanMatchResult Match(const std::vector<Rigid2>& before,
                      const Building& building,
                      const std::vector<Rigid2>& after) {
  ScanMatchInput input{{ScansAt(kHall, before, 0.01)}, {}};
  for (SignalSample& scan : ScansAt(building, after, 0.01).samples) {
    scan.time_ns += input.scans[0].samples.back().time_ns + kPause_ns;
    input.scans[0].samples.push_back(scan);
  }
  Progress progress("scan_match", false);
  return RunScanMatch({}, input, progress);
}

// The last pose against where the robot is, in the frame of the first.
double LastError_m(const ScanMatchResult& result, const Rigid2& first, const Rigid2& last) {
  const Rigid2 error = (first.Inverse() * last).Inverse() * result.scans.back().start_from_robot;
  return error.translation.norm() + std::abs(WrapAngle_rad(error.heading_rad));
}

bool HasUnknownEdge(const ScanMatchResult& result) {
  return std::ranges::any_of(result.edges.edges,
                             [](const SensorEdge& edge) { return edge.covariance(2, 2) > 1; });
}

TEST(ScanMatchPause, ARobotThatStoodStillGoesOn) {
  const auto before = Straight({0, {-3, 0}}, 20);
  const auto after = Straight(before.back(), 20);
  const ScanMatchResult result = Match(before, kHall, after);
  EXPECT_LT(LastError_m(result, before[0], after.back()), 0.04);
  EXPECT_FALSE(HasUnknownEdge(result));
}

// The edge to the first keyscan elsewhere says that it is not known, and the way there is right in
// itself.
TEST(ScanMatchPause, ElsewhereAPartOfItsOwnBegins) {
  const auto before = Straight({0, {-3, 0}}, 20);
  const auto after = Straight({0.5, {-2, -2}}, 20);
  for (const Building& building : {kHall, kOther}) {
    const ScanMatchResult result = Match(before, building, after);
    EXPECT_TRUE(HasUnknownEdge(result));
    const Rigid2 way =
        result.scans[20].start_from_robot.Inverse() * result.scans[39].start_from_robot;
    EXPECT_LT((way.translation - Eigen::Vector2d(1.9, 0)).norm(), 0.04);
  }
}

}  // namespace nightmap::pause_test
