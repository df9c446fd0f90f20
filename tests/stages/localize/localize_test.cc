// SPDX-License-Identifier: Apache-2.0
#include "stages/localize/localize.h"

#include "pipeline/base/error.h"
#include "stages/localize/localize_report.h"
#include "stages/localize/localizer.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

// The map of the scene as the landmarks stage would make it, without that stage.
LandmarkMap MakeMap(const LandmarkScene& scene, const VocabularyTree& tree) {
  LandmarkMap map;
  map.num_word_levels = tree.Depth();
  for (std::size_t i = 0; i < scene.frames.size(); ++i) {
    map.keyframes.push_back({static_cast<int>(i), scene.poses[i].time_ns, scene.poses[i].pose});
  }
  map.landmark_keyframes.resize(scene.points_in_map.size());
  for (std::size_t i = 0; i < scene.frames.size(); ++i) {
    for (const int point : scene.frame_points[i]) {
      map.landmark_keyframes[static_cast<std::size_t>(point)].push_back(static_cast<int>(i));
    }
  }
  map.positions_in_map = scene.points_in_map;
  map.position_sigmas_m.assign(scene.points_in_map.size(), 0.01F);
  for (std::size_t i = 0; i < scene.descriptors.size(); ++i) {
    const auto& descriptor = scene.descriptors[i];
    map.descriptors.insert(map.descriptors.end(), descriptor.begin(), descriptor.end());
    map.descriptor_landmarks.push_back(static_cast<int>(i));
    std::vector<int> path = tree.Path(descriptor.data());
    path.resize(static_cast<std::size_t>(tree.Depth()), path.back());
    map.words.insert(map.words.end(), path.begin(), path.end());
  }
  return map;
}

class LocalizeTest : public testing::Test {
 protected:
  QueryResult Localize(const FrameFeatures& features) const {
    const Localizer localizer(options_, map_, vocabulary_);
    return localizer.Localize(query_, scene_.cameras[0].color, features);
  }
  void ExpectLocated(const QueryResult& result) const {
    ASSERT_TRUE(result.IsLocated()) << result.reason;
    EXPECT_NEAR((result.map_from_camera.translation - pose_.translation).norm(), 0, 1e-3);
    EXPECT_NEAR(AngleBetween_rad(result.map_from_camera, pose_), 0, 1e-3);
    EXPECT_LT(result.reprojection_error_px, 0.1);
  }
  std::vector<QueryResult> Run(int num_threads = 1) const {
    Progress progress("localize", false);
    return RunLocalize(options_, input_, progress, num_threads);
  }

  LandmarkScene scene_ = MakeLandmarkScene();
  Vocabulary vocabulary_ = MakeSceneVocabulary(scene_);
  LandmarkMap map_ = MakeMap(scene_, vocabulary_.tree);
  LocalizeOptions options_;
  FrameRecord query_{5, 77, "query.png", "", 0, 0, ""};
  Rigid3 pose_ = ScenePose(0.15, -0.1);
  FrameFeatures features_ = scene_.See(pose_, 0, nullptr);
  LocalizeInput input_{{query_},
                       scene_.cameras,
                       {},
                       &map_,
                       &vocabulary_,
                       [](const FrameRecord&, const RgbdCamera& camera) {
                         ColorImage gray{camera.color.width, camera.color.height, 3, {}};
                         gray.pixels.assign(static_cast<std::size_t>(640 * 480 * 3), 128);
                         return gray;
                       }};
};

TEST_F(LocalizeTest, FindsThePose) {
  const QueryResult result = Localize(features_);
  ExpectLocated(result);
  EXPECT_EQ(result.query_idx, 5);
  EXPECT_EQ(result.time_ns, 77);
  EXPECT_EQ(result.num_inliers, features_.NumFeatures());
}

TEST_F(LocalizeTest, FindsThePoseAmongManyWrongFeatures) {
  Random random(9);
  const int num_true = features_.NumFeatures();
  for (int i = 0; i < 2 * num_true; ++i) {
    const auto descriptor = RandomRootSift(random);
    features_.keypoints_px.emplace_back(random.Uniform(0, 639), random.Uniform(0, 479));
    features_.descriptors.insert(features_.descriptors.end(), descriptor.begin(), descriptor.end());
  }
  ExpectLocated(Localize(features_));
}

// With words that lead nowhere only the retrieval can help.
TEST_F(LocalizeTest, FallsBackToRetrieval) {
  std::fill(map_.words.begin(), map_.words.end(), 0);
  ExpectLocated(Localize(features_));
}

TEST_F(LocalizeTest, MatchesToTheRightLandmarks) {
  const LandmarkMatcher matcher(options_, map_, vocabulary_);
  std::vector<int> seen;
  scene_.See(pose_, 0, &seen);
  for (const auto& matches :
       {matcher.SearchByWords(features_),
        matcher.SearchByRetrieval(features_),
        matcher.SearchByPose(features_, scene_.cameras[0].color, pose_.Inverse(), seen)}) {
    EXPECT_GT(matches.size(), seen.size() / 2);
    for (const LandmarkMatch& match : matches) {
      EXPECT_EQ(match.landmark, seen[static_cast<std::size_t>(match.feature)]);
    }
  }
}

// The same descriptor at two distant points is ambiguous, at two near ones it is not.
TEST_F(LocalizeTest, RatioTestComparesDifferentPoints) {
  std::vector<int> seen;
  scene_.See(pose_, 0, &seen);
  for (const bool near : {true, false}) {
    LandmarkMap twins = map_;
    const int first = seen[0];
    const auto point = static_cast<std::size_t>(first);
    const Eigen::Vector3d step(near ? 0.01 : 1.0, 0, 0);
    twins.positions_in_map.push_back(map_.positions_in_map[point] + step);
    twins.position_sigmas_m.push_back(0.01F);
    twins.landmark_keyframes.push_back(map_.landmark_keyframes[point]);
    twins.descriptor_landmarks.push_back(map_.NumLandmarks());
    twins.descriptors.insert(
        twins.descriptors.end(), map_.Descriptor(first), map_.Descriptor(first) + 128);
    for (int level = 1; level <= map_.num_word_levels; ++level) {
      twins.words.push_back(map_.Word(first, level));
    }
    bool matched = false;
    for (const auto& match :
         LandmarkMatcher(options_, twins, vocabulary_).SearchByWords(features_)) {
      matched = matched || match.feature == 0;
    }
    EXPECT_EQ(matched, near);
  }
}

TEST_F(LocalizeTest, FailsWithAReason) {
  EXPECT_EQ(Localize(FrameFeatures{}).reason, "no_features");
  Random random(11);
  FrameFeatures foreign = features_;
  foreign.descriptors.clear();
  for (int i = 0; i < foreign.NumFeatures(); ++i) {
    const auto descriptor = RandomRootSift(random);
    foreign.descriptors.insert(foreign.descriptors.end(), descriptor.begin(), descriptor.end());
  }
  EXPECT_EQ(Localize(foreign).reason, "too_few_matches");
  FrameFeatures shuffled = features_;
  std::reverse(shuffled.keypoints_px.begin(), shuffled.keypoints_px.end());
  const QueryResult result = Localize(shuffled);
  EXPECT_EQ(result.reason, "too_few_inliers");
  EXPECT_GT(result.num_matches, 12);
}

TEST_F(LocalizeTest, EveryQueryGetsARow) {
  input_.queries.assign(3, query_);
  input_.queries[1].color_path = "broken.png";
  const auto load_gray = input_.load_color;
  input_.load_color = [&](const FrameRecord& query, const RgbdCamera& camera) {
    if (query.color_path == "broken.png") throw DataError("broken.png: truncated");
    return load_gray(query, camera);
  };
  const auto results = Run(2);
  ASSERT_EQ(results.size(), 3U);
  EXPECT_EQ(results[0].reason, "no_features");
  EXPECT_EQ(results[1].reason, "unreadable_image");
  EXPECT_EQ(QueriesToCsv(results), QueriesToCsv(Run(1)));
  const auto report = SummarizeQueries(results);
  EXPECT_EQ(report["num_located"], 0);
  EXPECT_EQ(report["num_failed_by_reason"]["no_features"], 2);
  EXPECT_EQ(report["num_failed_by_reason"]["unreadable_image"], 1);
}

TEST_F(LocalizeTest, RefusesInputsThatDoNotBelongTogether) {
  input_.queries.clear();
  NIGHTMAP_EXPECT_ERROR(DataError, Run(), "no queries");
  input_.queries = {query_};
  input_.queries[0].camera_idx = 1;
  NIGHTMAP_EXPECT_ERROR(DataError, Run(), "camera_idx");
  input_.queries = {query_};
  input_.extraction.detector = "orb";
  NIGHTMAP_EXPECT_ERROR(DataError, Run(), "another vocabulary");
  input_.extraction.detector = "sift";
  map_.words[0] = vocabulary_.tree.NumNodes();
  NIGHTMAP_EXPECT_ERROR(DataError, Run(), "another vocabulary");
}

}  // namespace
}  // namespace nightmap
