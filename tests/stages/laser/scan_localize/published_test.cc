// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/published.h"

#include <gtest/gtest.h>

#include <numbers>

#include "pipeline/laser/scan_grid.h"
#include "stages/laser/scan_localize/object_evidence.h"
#include "stages/laser/scan_localize/scan_localize.h"
#include "tests/laser_building.h"

namespace nightmap::published_test {

constexpr double kDegree_rad = std::numbers::pi / 180;

// A room that looks the same when turned by half a circle about the origin, but for one pillar.
const Building kRoom{{{-5, -3}, {5, 3}}, {{2.5, 2.6}, {3.5, 3}}};
const MapObject kPillar{"pillar", {0, {3, 2.7}}, {2, 0.8}, {}};
const Rigid2 kTruth{0.7, {2, -1}};
const Rigid2 kTurned{0.7 - std::numbers::pi, {-2, 1}};

OccupancyGrid GridOf(const Building& building) {
  const std::vector<Rigid2> poses{
      {0, {0, 0}}, {1, {2, 1}}, {2, {3.9, 1}}, {3, {-3, 1}}, {0.5, {2, -1}}};
  const Signal scans = ScansAt(building, poses, 0);
  std::vector<PlacedScan> placed;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    placed.push_back(
        {poses[i].ToRigid3(), -std::numbers::pi, kDegree_rad, 80, scans.samples[i].ranges_m, {}});
  }
  return GridOfScans({}, placed).grid;
}

ScanQuery QueryAt(const Rigid2& pose) {
  const Signal scans = ScansAt(kRoom, {pose}, 0.01);
  ScanQuery query{"query", 1, {}, RoughPosition{{0.5, 0}, 4}};
  query.scans.push_back({{}, -std::numbers::pi, kDegree_rad, 80, scans.samples[0].ranges_m});
  return query;
}

class Published : public testing::Test {
 protected:
  Published() : map_({}, GridOf(kRoom), 1) {}

  ObjectScene Scene(const ScanQuery& query) const { return {map_.Grid(), query, 30}; }
  std::vector<NearObject> Near(const ScanQuery& query) const {
    return ObjectsNear(options_.filter, Scene(query), {kPillar});
  }
  std::vector<ObjectPose> Poses(const ScanQuery& query,
                                const std::vector<TemplateMatch>& matches = {}) const {
    return PosesByObjects(options_.filter, Scene(query), Near(query), matches);
  }
  std::vector<TemplateMatch> Filter(const ScanQuery& query,
                                    const std::vector<ObjectPose>& poses,
                                    const std::vector<TemplateMatch>& matches) const {
    return FilterByPoses(options_.filter, Scene(query), Near(query), poses, matches);
  }
  std::vector<ScanCandidate> Find(const ScanQuery& query,
                                  const std::vector<MapObject>& objects) const {
    return FindCandidatesAsPublished(options_, {}, map_, objects, query).candidates;
  }

  PublishedOptions options_;
  ScanMap map_;
};

bool HasPlace(const std::vector<TemplateMatch>& matches, const Rigid2& place) {
  return std::ranges::any_of(matches, [&](const TemplateMatch& match) {
    return IsSamePlace(match.map_from_query, place);
  });
}

void ExpectNear(const Rigid2& found, const Rigid2& truth) {
  EXPECT_LT((found.translation - truth.translation).norm(), 0.05);
  EXPECT_LT(std::abs(WrapAngle_rad(found.heading_rad - truth.heading_rad)), kDegree_rad);
}

TEST_F(Published, FindsThePoseWithARoughPosition) {
  const auto candidates = Find(QueryAt(kTruth), {kPillar});
  ASSERT_FALSE(candidates.empty());
  ExpectNear(candidates.front().map_from_query, kTruth);
  EXPECT_GT(candidates.front().search_score, 0.5);
  EXPECT_GT(candidates.front().score, 0.7);
  EXPECT_LT(candidates.front().through_share, 0.05);
  EXPECT_GT(candidates.front().covariance.determinant(), 0);
}

TEST_F(Published, FindsThePoseInTheWholeMap) {
  ScanQuery query = QueryAt(kTruth);
  query.rough_position.reset();
  const auto candidates = Find(query, {});
  ASSERT_FALSE(candidates.empty());
  ExpectNear(candidates.front().map_from_query, kTruth);
}

TEST_F(Published, PosesByObjectsHoldTheTrueOne) {
  const auto poses = Poses(QueryAt(kTruth));
  EXPECT_TRUE(std::ranges::any_of(poses, [](const ObjectPose& found) {
    const Rigid2& pose = found.map_from_query;
    return (pose.translation - kTruth.translation).norm() < 0.15 && found.overlap > 0.9 &&
           std::abs(WrapAngle_rad(pose.heading_rad - kTruth.heading_rad)) < 4 * kDegree_rad;
  })) << poses.size();
}

TEST_F(Published, PosesByObjectsStartFromThePlacesOfThePictureToo) {
  options_.filter.num_starts = 1;
  options_.filter.num_headings = 1;  // that of the map, which no scan of this test has
  const ScanQuery query = QueryAt(kTruth);
  const auto poses = Poses(query, {{{0.75, {2.1, -1.1}}, 1}});
  EXPECT_TRUE(std::ranges::any_of(poses, [](const ObjectPose& found) {
    return (found.map_from_query.translation - kTruth.translation).norm() < 0.15;
  })) << poses.size();
}

TEST_F(Published, AMatchFromWhichTheObjectIsSeenStaysHoweverNearABetterOne) {
  options_.filter.filter_distance_m = 0.02;
  const ScanQuery query = QueryAt(kTruth);
  const std::vector<TemplateMatch> matches{{kTruth, 1}, {{0.7, {2, -0.92}}, 1}};
  const auto poses = Poses(query, matches);
  EXPECT_EQ(Filter(query, poses, matches).size(), 2U);
  EXPECT_LT(PosesApart(poses).size(), poses.size());
}

TEST(PosesApart, TheBestPoseOfAnObjectAtAPlaceStays) {
  const Rigid2 near{0.7, {2.1, -1}};
  const auto apart = PosesApart(
      {{1, kTruth, 20, 0.7}, {0, near, 20, 0.6}, {0, kTruth, 20, 0.8}, {0, kTurned, 20, 0.9}});
  std::vector<std::pair<std::size_t, double>> found;
  for (const ObjectPose& pose : apart) found.emplace_back(pose.object_idx, pose.overlap);
  EXPECT_EQ(found, (std::vector<std::pair<std::size_t, double>>{{0, 0.9}, {0, 0.8}, {1, 0.7}}));
}

class InSight : public Published {
 protected:
  static QueryScan ScanIn(const Building& building, const Rigid2& map_from_laser) {
    const Signal scans = ScansAt(building, {map_from_laser}, 0);
    return {map_from_laser, -std::numbers::pi, kDegree_rad, 80, scans.samples[0].ranges_m};
  }
  // Confirmed and contradicted walls, of a query in the frame of the map.
  std::vector<int> Count(const std::vector<Eigen::Vector2d>& walls,
                         const std::vector<QueryScan>& scans) const {
    const ObjectView view = ViewInSight(map_.Grid(), walls, {"query", 1, scans, {}}, {}, 30);
    return {view.num_confirmed, view.num_contradicted};
  }

  const Building without_pillar_{kRoom[0]};
  const Eigen::Vector2d right_wall_{5, 2.5};
  const QueryScan sees_ = ScanIn(kRoom, {0, {3.7, 1}});
  // The pillar, which was taken away, hides the wall from here in the map.
  const QueryScan hidden_ = ScanIn(without_pillar_, {0, {2, 2.8}});
};

TEST_F(InSight, AWallBehindAnotherOfTheMapSaysNothing) {
  EXPECT_EQ(Count({right_wall_}, {sees_}), (std::vector<int>{1, 0}));
  EXPECT_EQ(Count({right_wall_}, {hidden_}), (std::vector<int>{0, 0}));
  EXPECT_EQ(ViewObjects({right_wall_}, {"query", 1, {hidden_}, {}}, {}, 30).num_confirmed, 1);
}

// One laser has the wall in sight, but stands behind a person; the other sees where it cannot.
TEST_F(InSight, SightAndHitAreOfTheSameLaser) {
  QueryScan blocked = sees_;
  for (float& range_m : blocked.ranges_m) range_m = 0.5F;
  EXPECT_EQ(Count({right_wall_}, {blocked, hidden_}), (std::vector<int>{0, 0}));
}

TEST_F(InSight, AWallThatSeveralLasersSeeCountsOnce) {
  const QueryScan through = ScanIn(without_pillar_, {0, {3, 1}});
  const Eigen::Vector2d front{3, 2.6};
  EXPECT_EQ(Count({right_wall_}, {sees_, sees_}), (std::vector<int>{1, 0}));
  EXPECT_EQ(Count({front}, {through, through}), (std::vector<int>{0, 1}));
  EXPECT_EQ(Count({front}, {through, ScanIn(kRoom, {0, {3, 1}})}), (std::vector<int>{1, 0}));
}

TEST_F(Published, BeamsThatPassThroughAWallAreAgainstItAndThoseThatEndBeforeSayNothing) {
  const ScanQuery query = QueryAt(kTruth);
  const auto count = [&](const std::vector<Eigen::Vector2d>& walls) {
    const ObjectView view = ViewObjects(walls, query, kTruth, 30);
    return std::vector<int>{view.num_confirmed, view.num_contradicted};
  };
  EXPECT_EQ(count({{3, 2.6}}), (std::vector<int>{1, 0}));
  EXPECT_EQ(count({{2.5, 1}}), (std::vector<int>{0, 1}));
  EXPECT_EQ(count({{3, 4}}), (std::vector<int>{0, 0}));
}

TEST_F(Published, ObjectsRemoveTheAlikePlace) {
  const ScanQuery query = QueryAt(kTruth);
  const auto matches = SearchTemplate(options_.search, map_, query);
  ASSERT_TRUE(HasPlace(matches, kTruth));
  ASSERT_TRUE(HasPlace(matches, kTurned));  // by the picture alone it is one of the best
  EXPECT_GT(matches[1].score, 0.7 * matches[0].score);
  const auto filtered = Filter(query, Poses(query, matches), matches);
  EXPECT_TRUE(HasPlace(filtered, kTruth));
  EXPECT_FALSE(HasPlace(filtered, kTurned));
}

TEST_F(Published, OfPlacesWithinTheSuppressionRadiusTheBestStays) {
  const ScanQuery query = QueryAt(kTruth);
  options_.search.min_share_of_best = 0.3;
  std::size_t num_before = options_.search.max_candidates = 1000;
  for (const double radius_m : {0.1, 0.5, 2.0}) {
    options_.search.suppression_radius_m = radius_m;
    const auto matches = SearchTemplate(options_.search, map_, query);
    EXPECT_TRUE(HasPlace(matches, kTruth)) << radius_m;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        EXPECT_FALSE(IsSamePlace(matches[i].map_from_query, matches[k].map_from_query, radius_m));
      }
    }
    EXPECT_LT(matches.size(), num_before) << radius_m;
    num_before = matches.size();
  }
}

// From a place with no object in sight, objects say nothing of it.
TEST_F(Published, PlacesThatSeeNoObjectStay) {
  ScanQuery query = QueryAt(kTruth);
  const std::vector<ObjectPose> elsewhere{{0, {0, {-4, -2}}, 20, 1}};
  EXPECT_TRUE(Filter(query, elsewhere, {{kTruth, 1}}).empty());
  query.scans[0].ranges_m.resize(90);  // those behind it, where there is no pillar
  EXPECT_TRUE(HasPlace(Filter(query, elsewhere, {{kTruth, 1}}), kTruth));
}

// A place is not better for objects that it half explains, and a beam through a wall weighs more
// than one that ends on it.
TEST(ObjectEvidence, RaisesTheFitByWhatIsLikelierAtTheTruePlaceThanByChance) {
  const auto change = [](const ObjectView& objects) { return FitByEvidence(0.4, objects) - 0.4; };
  EXPECT_EQ(change({0, 0}), 0);
  EXPECT_GT(change({20, 0}), 0);
  EXPECT_LT(change({15, 10}), 0);
  EXPECT_GT(change({40, 0}), change({20, 0}));
  EXPECT_LT(change({0, 40}), change({0, 20}));
  EXPECT_GT(-change({0, 40}), 3 * change({40, 0}));
}

TEST(ObjectEvidence, SpeaksAgainstAPlaceThatManyBeamsPassThrough) {
  EXPECT_TRUE(SpeakAgainst({130, 65}));
  EXPECT_FALSE(SpeakAgainst({130, 6}));
  EXPECT_FALSE(SpeakAgainst({2, 5}));  // too few
  EXPECT_FALSE(SpeakAgainst({0, 0}));
}

TEST(Judge, RefusesAPlaceThatObjectsSpeakAgainstWhereTheyAreWeighed) {
  ScanCandidate best, other;
  best.fit = best.walls_fit = best.score = 0.9;
  best.objects = {20, 20};
  best.on_wall.assign(100, true);
  other.fit = other.walls_fit = other.score = 0.3;
  other.on_wall.assign(100, false);
  EXPECT_EQ(Judge({}, {}, 100, {best, other}, false).verdict, QueryVerdict::kLocated);
  EXPECT_EQ(Judge({}, {}, 100, {best, other}, true).verdict, QueryVerdict::kNotInMap);
}

// Both explain the same points. The objects of one have their say in its fit, and in nothing else.
TEST(Judge, ObjectsThatAreWeighedDecideNothingBesideTheFit) {
  ScanCandidate best, other;
  best.fit = best.walls_fit = best.score = 0.9;
  best.objects = {30, 0};
  best.on_wall.assign(100, true);
  other = best;
  other.fit = 0.82;
  other.objects = {};
  EXPECT_EQ(Judge({}, {}, 100, {best, other}, false).verdict, QueryVerdict::kLocated);
  EXPECT_EQ(Judge({}, {}, 100, {best, other}, true).verdict, QueryVerdict::kAmbiguous);
}

TEST_F(Published, ObjectsFarAwayDoNotFilter) {
  options_.filter.object_distance_m = 1;
  const ScanQuery query = QueryAt(kTruth);
  EXPECT_TRUE(Poses(query).empty());
  const auto matches = SearchTemplate(options_.search, map_, query);
  EXPECT_EQ(Filter(query, {}, matches).size(), matches.size());
  EXPECT_EQ(Find(query, {kPillar}).size(), Find(query, {}).size());
}

TEST_F(Published, NoObjectsAreSoughtWithoutARoughPosition) {
  ScanQuery query = QueryAt(kTruth);
  query.rough_position.reset();
  EXPECT_TRUE(Poses(query).empty());
}

TEST_F(Published, CandidatesLieWithinTheRoughPosition) {
  ScanQuery query = QueryAt(kTruth);
  query.rough_position = RoughPosition{{-2, 1}, 1};
  for (const TemplateMatch& match : SearchTemplate(options_.search, map_, query)) {
    EXPECT_LE((match.map_from_query.translation - Eigen::Vector2d(-2, 1)).norm(), 1.3);
  }
}

TEST(ScanLocalize, PublishedIsTheSameAtAnyNumberOfThreads) {
  ScanLocalizeOptions options;
  options.method = "published";
  ScanLocalizeInput input{GridOf(kRoom), {}, {kPillar}};
  for (const double x_m : {1.0, 1.5, 2.0, 2.5}) {
    input.queries.push_back(QueryAt({x_m, {x_m, -1}}));
    input.queries.back().time_ns = static_cast<std::int64_t>(input.queries.size());
  }
  Progress silent("scan_localize", false);
  const auto once = RunScanLocalize(options, input, silent, 1);
  for (const int num_threads : {1, 4}) {
    const auto again = RunScanLocalize(options, input, silent, num_threads);
    ASSERT_EQ(again.size(), once.size());
    for (std::size_t i = 0; i < once.size(); ++i) {
      ASSERT_FALSE(once[i].candidates.empty());
      ASSERT_EQ(again[i].candidates.size(), once[i].candidates.size());
      for (std::size_t j = 0; j < once[i].candidates.size(); ++j) {
        const ScanCandidate &a = once[i].candidates[j], &b = again[i].candidates[j];
        EXPECT_EQ(a.map_from_query.translation, b.map_from_query.translation);
        EXPECT_EQ(a.map_from_query.heading_rad, b.map_from_query.heading_rad);
        EXPECT_EQ(a.fit, b.fit);
        EXPECT_EQ(a.covariance, b.covariance);
      }
    }
  }
}

}  // namespace nightmap::published_test
