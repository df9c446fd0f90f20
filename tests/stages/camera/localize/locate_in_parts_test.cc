// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/locate_in_parts.h"

#include <map>

#include "pipeline/base/error.h"
#include "pipeline/io/queries_io.h"
#include "stages/camera/localize/localizer.h"
#include "stages/camera/localize/mirror_features.h"
#include "tests/stages/camera/localize/scene_map.h"
#include "tests/test_data.h"

namespace nightmap::locate_in_parts_test {

// The scene and a far copy that looks the same.
class LocateInPartsTest : public testing::Test {
 protected:
  static constexpr double kFar_m = 200;

  void SetUp() override {
    GoAgain(&scene_);
    AddTwin({Eigen::Quaterniond::Identity(), {kFar_m, 0, 0}}, &map_);
    for (int i = 0; i < 14; ++i) {
      FrameRecord query{i, 77 + i, 0, 0, {"query.png", "h"}, {}, {}};
      queries_.push_back(query);
      poses_.push_back(ScenePose(-0.8 + 0.12 * i, 0.1 - 0.015 * i));
      features_.push_back(scene_.See(poses_.back(), 0, nullptr));
    }
  }
  // Removes the copy.
  void LeaveOne() {
    scene_ = MakeLandmarkScene();
    vocabulary_ = IndexOf(MakeSceneVocabulary(scene_));
    map_ = MakeSceneMap(scene_, vocabulary_.tree);
  }

  std::vector<QueryResult> Locate(MapParts& parts,
                                  std::span<const FrameRecord> queries,
                                  int threads) {
    const auto describe = [&](const FrameRecord& query) {
      return DescribedPicture{
          features_[static_cast<std::size_t>(query.frame_idx)], {scene_.cameras[0].color}, ""};
    };
    std::vector<QueryResult> results;
    for (const LocatedPicture& located : LocateInParts(
             options_, queries, describe, [](const char*) {}, parts, NoProgress(), threads)) {
      EXPECT_EQ(located.problem, "");
      results.push_back(located.result);
    }
    return results;
  }
  // With bounds between regions at these x.
  std::vector<QueryResult> Locate(const std::vector<double>& bounds_m, int threads = 2) {
    MapInRegions map = InRegions(map_, bounds_m);
    const auto read = map.read;
    num_reads_.clear();
    map.read = [&, read](std::size_t region) {
      ++num_reads_[region];
      return read(region);
    };
    MapParts parts(options_, map, vocabulary_, limits_);
    return Locate(parts, queries_, threads);
  }
  std::vector<QueryResult> LocateWhole() const {
    const Localizer localizer(options_, map_, vocabulary_);
    std::vector<QueryResult> results;
    for (std::size_t i = 0; i < queries_.size(); ++i) {
      results.push_back(localizer.Localize(queries_[i], {scene_.cameras[0].color}, features_[i]));
    }
    return results;
  }

  LandmarkScene scene_ = MakeLandmarkScene();
  VocabularyIndex vocabulary_ = [] {
    LandmarkScene scene = MakeLandmarkScene();
    GoAgain(&scene);
    return IndexOf(MakeSceneVocabulary(scene));
  }();
  LandmarkMap map_ = MakeSceneMap(MakeLandmarkScene(), vocabulary_.tree);
  LocalizeOptions options_;
  MapLimits limits_;
  std::vector<FrameRecord> queries_;
  std::vector<Rigid3> poses_;
  std::vector<FrameFeatures> features_;
  std::map<std::size_t, int> num_reads_;
};

TEST_F(LocateInPartsTest, PartsGiveThePosesOfTheWholeMap) {
  LeaveOne();
  const auto whole = LocateWhole();
  for (const std::int64_t part_landmarks : {1, 400, 1'000'000}) {
    limits_.part_landmarks = part_landmarks;
    const auto in_parts = Locate({-1, 0, 1});
    for (std::size_t i = 0; i < whole.size(); ++i) {
      ASSERT_TRUE(whole[i].IsLocated()) << whole[i].reason;
      ASSERT_TRUE(in_parts[i].IsLocated()) << part_landmarks << ' ' << in_parts[i].reason;
      const Rigid3& found = in_parts[i].map_from_camera;
      EXPECT_LT((found.translation - whole[i].map_from_camera.translation).norm(), 1e-3);
      EXPECT_LT((found.translation - poses_[i].translation).norm(), 1e-3);
      EXPECT_LT(AngleBetween_rad(found, poses_[i]), 1e-3);
    }
  }
}

TEST_F(LocateInPartsTest, APartWithAllNeighboursGivesTheRowsOfTheWholeMap) {
  LeaveOne();
  limits_.parts_per_picture = 1;
  EXPECT_EQ(QueriesToCsv(Locate({0})), QueriesToCsv(LocateWhole()));
}

TEST_F(LocateInPartsTest, APlaceWithALikenessInAFarPartIsAmbiguous) {
  for (const QueryResult& result : Locate({0, kFar_m / 2})) {
    EXPECT_EQ(result.verdict, QueryVerdict::kAmbiguous);
    EXPECT_EQ(result.reason, "rival_place");
    EXPECT_EQ(result.num_rival_inliers, result.num_inliers);
    EXPECT_EQ(result.confidence, 0);
  }
  LeaveOne();
  for (const QueryResult& result : Locate({0, kFar_m / 2})) {
    EXPECT_TRUE(result.IsLocated()) << result.reason;
    EXPECT_GT(result.confidence, 0.8);
  }
}

// The far copy lacks most landmarks: the features vote for the place that explains more of them.
TEST_F(LocateInPartsTest, TheBetterOfTwoPartsIsThePlace) {
  const double thin_m = kFar_m + 0.7;
  for (std::size_t i = 0; i < map_.positions_in_map.size(); ++i) {
    double& x_m = map_.positions_in_map[i].x();
    if (x_m > kFar_m / 2 && x_m < thin_m) x_m += 2 * kFar_m;  // away, and out of place
  }
  const auto results = Locate({kFar_m / 2});
  for (std::size_t i = 0; i < results.size(); ++i) {
    ASSERT_TRUE(results[i].IsLocated()) << results[i].reason;
    EXPECT_LT((results[i].map_from_camera.translation - poses_[i].translation).norm(), 1e-3);
  }
}

TEST_F(LocateInPartsTest, AMirroredPictureIsNotInTheMap) {
  for (FrameFeatures& features : features_) {
    features = *MirrorFeatures(features, map_.kind, scene_.cameras[0].color);
  }
  for (const QueryResult& result : Locate({0, kFar_m / 2})) {
    EXPECT_EQ(result.verdict, QueryVerdict::kNotInMap);
    EXPECT_EQ(result.reason, "mirrored");
  }
}

TEST_F(LocateInPartsTest, WhatIsNotInTheMapIsNotFound) {
  Random random(4);
  features_[0].descriptors.clear();
  for (int i = 0; i < features_[0].NumFeatures(); ++i) AddRandomDescriptor(random, &features_[0]);
  features_[1] = {};
  const auto results = Locate({0, kFar_m / 2});
  EXPECT_EQ(results[0].verdict, QueryVerdict::kNotInMap);
  EXPECT_EQ(results[1].verdict, QueryVerdict::kNoFeatures);
}

TEST_F(LocateInPartsTest, ResultsDependNeitherOnThreadsNorOnOtherPicturesNorOnMemory) {
  const std::vector<double> bounds_m = {-1, 0, 1, kFar_m / 2};
  limits_.part_landmarks = 400;
  const std::string expected = QueriesToCsv(Locate(bounds_m, 1));
  EXPECT_EQ(QueriesToCsv(Locate(bounds_m, 4)), expected);
  limits_.bytes = 0;
  EXPECT_EQ(QueriesToCsv(Locate(bounds_m, 4)), expected);
  const MapInRegions map = InRegions(map_, bounds_m);
  MapParts parts(options_, map, vocabulary_, limits_);
  std::vector<QueryResult> one_by_one;
  for (const FrameRecord& query : queries_) {
    one_by_one.push_back(Locate(parts, {&query, 1}, 1)[0]);
  }
  EXPECT_EQ(QueriesToCsv(one_by_one), expected);
}

// In a batch each part is read once, whatever memory there is.
TEST_F(LocateInPartsTest, ReadsARegionOncePerPart) {
  limits_.bytes = 0;
  limits_.part_landmarks = 1;  // each region is a part
  Locate({0, kFar_m / 2});
  ASSERT_FALSE(num_reads_.empty());
  for (const auto& [region, count] : num_reads_) EXPECT_EQ(count, 1) << region;
}

TEST_F(LocateInPartsTest, APartLittleAlikeIsReadOnlyForPicturesThatNoOtherLocates) {
  // The copy's keyframes share an eighth of their words with the place's; the others are all one.
  Random random(6);
  const auto repeated = RandomRootSift(random);
  auto& frames = scene_.features.frames;
  for (std::size_t i = frames.size() / 2; i < frames.size(); ++i) {
    for (int k = 0; k < frames[i].NumFeatures(); ++k) {
      const auto begin = frames[i].descriptors.begin() + k * DescriptorSize(map_.kind);
      if (k % 8 != 0) std::ranges::copy(repeated, begin);
    }
  }
  vocabulary_ = IndexOf(MakeSceneVocabulary(scene_));
  limits_.part_landmarks = 1;
  for (const QueryResult& result : Locate({kFar_m / 2})) {
    EXPECT_TRUE(result.IsLocated()) << result.reason;
    EXPECT_EQ(result.num_rival_inliers, 0);
  }
  EXPECT_EQ(num_reads_, (std::map<std::size_t, int>{{0, 1}}));
  options_.min_inliers = 1000;
  for (const QueryResult& result : Locate({kFar_m / 2})) {
    EXPECT_FALSE(result.IsLocated());
    EXPECT_GT(result.num_rival_inliers, 0);  // of the copy
  }
  EXPECT_EQ(num_reads_, (std::map<std::size_t, int>{{0, 1}, {1, 1}}));
}

TEST_F(LocateInPartsTest, KeepsThePartsThatWereWantedLast) {
  const MapInRegions map = InRegions(map_, {0, kFar_m / 2});
  limits_.part_landmarks = 1;
  MapParts roomy(options_, map, vocabulary_, limits_);
  limits_.bytes = 0;
  MapParts narrow(options_, map, vocabulary_, limits_);
  limits_.bytes = 500'000;  // two of the three
  MapParts middle(options_, map, vocabulary_, limits_);
  for (const std::size_t part : {0, 1, 0, 2}) {
    for (MapParts* parts : {&roomy, &narrow, &middle}) {
      parts->Load(part);
      EXPECT_TRUE(parts->IsLoaded(part));
    }
  }
  EXPECT_TRUE(roomy.IsLoaded(0) && roomy.IsLoaded(1));
  EXPECT_FALSE(narrow.IsLoaded(0) || narrow.IsLoaded(1));
  EXPECT_TRUE(middle.IsLoaded(0));
  EXPECT_FALSE(middle.IsLoaded(1));
}

// A part holds what its keyframes see: only the keyframes of the far place do not.
TEST_F(LocateInPartsTest, ThePartsMostAlikeSeeThePlaces) {
  const MapInRegions map = InRegions(map_, {-1, 0, 1, kFar_m / 2});
  const MapParts parts(options_, map, vocabulary_, limits_);
  for (const FrameFeatures& features : features_) {
    const auto alike = parts.MostAlike(features);
    ASSERT_EQ(alike.size(), 2U);  // one part of the place, one of its copy
    EXPECT_EQ(std::ranges::count(alike, 4U, &AlikePart::part), 1);
    EXPECT_GE(alike[0].score, alike[1].score);
    EXPECT_GT(alike[1].score, 0);
  }
}

TEST_F(LocateInPartsTest, RefusesWordsOfAnotherVocabulary) {
  map_.words.back() = vocabulary_.tree.NumNodes();
  NIGHTMAP_EXPECT_ERROR(DataError, Locate({kFar_m / 2}), "another vocabulary");
}

}  // namespace nightmap::locate_in_parts_test
