// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/submap_match.h"

#include <algorithm>

#include "pipeline/base/random.h"
#include "tests/stages/ceiling/ceiling_ekf/simulated_drive.h"
#include "tests/test_data.h"

namespace nightmap::submap_match_test {

const Rigid2 kNowFromThen{0.7, {1.2, -0.4}};

struct Places {
  std::vector<SubmapLandmark> now, then;
};

// The landmarks of a place, seen twice with 1 cm of noise, from two anchors.
Places Seen(const std::vector<Eigen::Vector3d>& points, bool look_alike) {
  Random random(5, 0, 0);
  Places places;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto noise = [&] {
      return Eigen::Vector3d(0.01 * random.Gaussian(), 0.01 * random.Gaussian(), 0);
    };
    const auto descriptor = DescriptorOf(look_alike ? 0 : i, 5);
    places.then.push_back({points[i] + noise(), descriptor});
    Eigen::Vector3d moved;
    moved << kNowFromThen * points[i].head<2>(), points[i].z();
    places.now.push_back({moved + noise(), descriptor});
  }
  return places;
}

std::vector<Eigen::Vector3d> Scattered(int num) {
  Random random(6, 0, 0);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < num; ++i) {
    points.emplace_back(4 * random.Uniform(), 4 * random.Uniform(), 2.6);
  }
  return points;
}

std::vector<Eigen::Vector3d> Tiles() {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 7; ++i) {
    for (int j = 0; j < 7; ++j) points.emplace_back(0.6 * i, 0.6 * j, 2.6);
  }
  return points;
}

Eigen::Matrix3d Sigmas(double position_m, double heading_rad) {
  return Eigen::Vector3d(position_m, position_m, heading_rad).cwiseAbs2().asDiagonal();
}

std::optional<SubmapMatch> Match(const Places& places,
                                 double off_m,
                                 const Eigen::Matrix3d& covariance) {
  const Rigid2 expected{kNowFromThen.heading_rad,
                        kNowFromThen.translation + Eigen::Vector2d(off_m, 0)};
  return MatchSubmaps({}, places.now, places.then, expected, covariance);
}

TEST(SubmapMatch, FindsThePoseOfAPlaceMetAgain) {
  const auto match = Match(Seen(Scattered(40), false), 1.5, Sigmas(1.5, 0.1));
  ASSERT_TRUE(match);
  EXPECT_GE(match->pairs.size(), 38U);
  EXPECT_LT((match->now_from_then.translation - kNowFromThen.translation).norm(), 0.02);
  EXPECT_NEAR(match->now_from_then.heading_rad, kNowFromThen.heading_rad, 0.005);
  for (const auto& [now, then] : match->pairs) EXPECT_EQ(now, then);
}

TEST(SubmapMatch, HasTheCovarianceOfItsError) {
  const auto match = Match(Seen(Scattered(40), false), 0, Sigmas(1, 0.1));
  ASSERT_TRUE(match);
  Eigen::Vector3d off;
  off << match->now_from_then.translation - kNowFromThen.translation,
      match->now_from_then.heading_rad - kNowFromThen.heading_rad;
  EXPECT_LT(off.dot(match->covariance.llt().solve(off)), 16);
}

TEST(SubmapMatch, TilesAreAmbiguousWhereTheFilterDoesNotTellThemApart) {
  const Places places = Seen(Tiles(), true);
  EXPECT_FALSE(Match(places, 0, Sigmas(0.5, 0.05)));
  const auto match = Match(places, 0.02, Sigmas(0.04, 0.01));
  ASSERT_TRUE(match);
  EXPECT_LT((match->now_from_then.translation - kNowFromThen.translation).norm(), 0.03);
}

TEST(SubmapMatch, FindsNothingElsewhere) {
  const Places places = Seen(Scattered(40), false);
  EXPECT_FALSE(Match(places, 3, Sigmas(0.1, 0.01)));
  Places others = Seen(Scattered(40), false);
  for (std::size_t i = 0; i < others.now.size(); ++i)
    others.now[i].descriptor = DescriptorOf(i + 1000, 5);
  EXPECT_FALSE(Match(others, 0, Sigmas(1, 0.1)));
  Places high = Seen(Scattered(40), false);
  for (SubmapLandmark& landmark : high.now) landmark.position.z() += 0.5;
  EXPECT_FALSE(Match(high, 0, Sigmas(1, 0.1)));
  EXPECT_FALSE(Match(Seen(Scattered(5), false), 0, Sigmas(1, 0.1)));
  EXPECT_FALSE(Match({}, 0, Sigmas(1, 0.1)));
}

}  // namespace nightmap::submap_match_test
