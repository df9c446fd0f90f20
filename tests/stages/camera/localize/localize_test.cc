// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/localize.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "stages/camera/localize/localize_report.h"
#include "stages/camera/localize/localizer.h"
#include "stages/camera/localize/mirror_features.h"
#include "stages/camera/localize/rolling_shutter_pose.h"
#include "tests/stages/camera/localize/scene_map.h"
#include "tests/test_data.h"

namespace nightmap::localize_test {

class LocalizeTest : public testing::Test {
 protected:
  QueryResult Localize(const FrameFeatures& features, const PictureLens& lens) const {
    const Localizer localizer(options_, map_, vocabulary_);
    return localizer.Localize(query_, lens, features);
  }
  QueryResult Localize(const FrameFeatures& features) const {
    return Localize(features, {scene_.cameras[0].color});
  }
  void ExpectLocated(const QueryResult& result) const {
    ASSERT_TRUE(result.IsLocated()) << result.reason;
    EXPECT_NEAR((result.map_from_camera.translation - pose_.translation).norm(), 0, 1e-3);
    EXPECT_NEAR(AngleBetween_rad(result.map_from_camera, pose_), 0, 1e-3);
    EXPECT_LT(result.reprojection_error_px, 0.1);
  }
  void MoveLandmarks(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& move) {
    std::ranges::transform(map_.positions_in_map, map_.positions_in_map.begin(), move);
    scene_.points_in_map = map_.positions_in_map;
    features_ = scene_.See(pose_, 0, nullptr);
  }
  FrameFeatures Mirrored(const FrameFeatures& features) const {
    return *MirrorFeatures(features, map_.kind, scene_.cameras[0].color);
  }
  std::vector<QueryResult> Run(int num_threads = 1) {
    regions_ = InRegions(map_);
    return RunLocalize(options_, input_, NoProgress(), num_threads);
  }

  LandmarkScene scene_ = MakeLandmarkScene();
  VocabularyIndex vocabulary_ = IndexOf(MakeSceneVocabulary(scene_));
  LandmarkMap map_ = MakeSceneMap(scene_, vocabulary_.tree);
  LocalizeOptions options_;
  FrameRecord query_{5, 77, 0, 0, {"query.png", "h"}, {}, {}};
  Rigid3 pose_ = ScenePose(0.15, -0.1);
  FrameFeatures features_ = scene_.See(pose_, 0, nullptr);
  MapInRegions regions_;
  LocalizeInput input_{{query_},
                       scene_.cameras,
                       {},
                       &regions_,
                       &vocabulary_,
                       [](const FrameRecord&, const RgbdCamera& camera) {
                         ColorImage gray{camera.color.width, camera.color.height, 3, {}};
                         gray.pixels.assign(static_cast<std::size_t>(640 * 480 * 3), 128);
                         return gray;
                       },
                       [this](const std::string& problem) { problems_.push_back(problem); }};
  std::vector<std::string> problems_;
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
    AddRandomDescriptor(random, &features_);
    features_.keypoints_px.emplace_back(random.Uniform(0, 639), random.Uniform(0, 479));
  }
  ExpectLocated(Localize(features_));
}

// With words that lead nowhere only the retrieval can help.
TEST_F(LocalizeTest, FallsBackToRetrieval) {
  std::fill(map_.words.begin(), map_.words.end(), 0);
  ExpectLocated(Localize(features_));
}

TEST_F(LocalizeTest, EverySearchAndSolverFindsThePose) {
  for (const char* search : {"combined", "2d_to_3d", "3d_to_2d", "tree"}) {
    for (const char* solver : {"p3p", "dlt6"}) {
      options_.search = search;
      options_.solver = solver;
      ExpectLocated(Localize(features_));
    }
  }
}

TEST_F(LocalizeTest, FindsThePoseAsPublished) {
  options_.solver = "dlt6";
  options_.prioritized = options_.covisibility_filter = options_.local_optimization = false;
  options_.num_retrieved_keyframes = options_.num_guided_keyframes = 0;
  options_.max_rival_ratio = 1;
  ExpectLocated(Localize(features_));
}

// Another size and lens: pixels become rays, so the map does not depend on the camera.
TEST_F(LocalizeTest, FindsThePoseWithAnotherCamera) {
  scene_.cameras[0].color = Camera{1000, 400, 700, 690, 480, 210};
  const QueryResult result = Localize(scene_.See(pose_, 0, nullptr));
  ExpectLocated(result);
}

// A guessed lens: its focal length is found with the pose.
TEST_F(LocalizeTest, FindsThePoseOfALensThatIsNotKnown) {
  const Camera& camera = scene_.cameras[0].color;
  for (const double scale : {0.5, 0.7, 0.9, 1.05, 1.2, 2.0}) {
    const QueryResult result = Localize(features_, {camera.WithFocalScale(scale), 0.3});
    ASSERT_TRUE(result.IsLocated()) << scale << ' ' << result.reason;
    EXPECT_LT((result.map_from_camera.translation - pose_.translation).norm(), 0.01) << scale;
    EXPECT_LT(AngleBetween_rad(result.map_from_camera, pose_), 0.005) << scale;
  }
}

TEST_F(LocalizeTest, TheLessIsKnownOfTheLensTheLessSureIsThePose) {
  const Camera& camera = scene_.cameras[0].color;
  double last_m = 0;
  for (const double sigma_ratio : {0.0, 0.002, 0.3}) {
    const QueryResult result = Localize(features_, {camera, sigma_ratio});
    EXPECT_GT(result.position_sigma_m, last_m) << sigma_ratio;
    last_m = result.position_sigma_m;
  }
}

// However many landmarks are seen, they share the error of their place.
TEST_F(LocalizeTest, ThePoseIsNoSurerThanTheMap) {
  const QueryResult fine = Localize(features_);
  std::ranges::fill(map_.position_sigmas_m, 0.1F);
  const QueryResult rough = Localize(features_);
  EXPECT_GT(fine.position_sigma_m, 0.01);
  EXPECT_GT(rough.position_sigma_m, 0.1);
  EXPECT_GT(rough.rotation_sigma_deg, fine.rotation_sigma_deg);
  EXPECT_EQ(rough.map_from_camera.translation, fine.map_from_camera.translation);
  EXPECT_LT(rough.confidence, fine.confidence);
}

// A picture rotated by a quarter turn: the camera is rolled, no more. (Descriptors rotate with the
// picture.)
TEST_F(LocalizeTest, FindsThePoseOfARolledCamera) {
  const Rigid3 roll{Eigen::Quaterniond(Eigen::AngleAxisd(1.5708, Eigen::Vector3d::UnitZ())),
                    Eigen::Vector3d::Zero()};
  pose_ = pose_ * roll;
  ExpectLocated(Localize(scene_.See(pose_, 0, nullptr)));
}

// A camera may turn about the line and see the same.
// Its picture is bent; a pose alone is off by a part of the turn.
TEST_F(LocalizeTest, FindsThePoseOfACameraThatTurnsWhileItsShutterRolls) {
  const ReadoutMotion motion{{0.004, -0.008, 0.002}, {0, 0, 0}};
  std::vector<int> seen;
  features_ = scene_.See(pose_, 0, &seen);
  const Camera& camera = scene_.cameras[0].color;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Eigen::Vector3d in_middle =
        pose_.Inverse() * scene_.points_in_map[static_cast<std::size_t>(seen[i])];
    const double row = static_cast<double>(features_.keypoints_px[i].y()) / camera.height - 0.5;
    features_.keypoints_px[i] =
        camera
            .ProjectUndistorted(in_middle + row * motion.PerReadout().Velocity_m_per_s(in_middle))
            ->cast<float>();
  }
  const QueryResult moving = Localize(features_);
  options_.readout_turn_sigma_rad = 0;
  const QueryResult still = Localize(features_);
  ASSERT_TRUE(moving.IsLocated() && still.IsLocated());
  EXPECT_GT(AngleBetween_rad(still.map_from_camera, pose_), 1e-3);
  EXPECT_LT(AngleBetween_rad(moving.map_from_camera, pose_), 2e-4);
  EXPECT_GE(moving.num_inliers, still.num_inliers);
}

TEST_F(LocalizeTest, LandmarksOnALineGiveNoPose) {
  MoveLandmarks([](const Eigen::Vector3d& point) {
    return Eigen::Vector3d(point.x(), 0.2 * point.x() + 0.1, 4 + 0.3 * point.x());
  });
  for (const char* solver : {"p3p", "dlt6"}) {
    options_.solver = solver;
    const QueryResult result = Localize(features_);
    EXPECT_EQ(result.verdict, QueryVerdict::kNotInMap) << solver;
    EXPECT_FALSE(result.reason.empty()) << solver;
  }
}

// A poster on a wall: enough for three points, not for six.
TEST_F(LocalizeTest, LandmarksOnAPlaneGiveAPoseToP3pOnly) {
  MoveLandmarks([](const Eigen::Vector3d& point) {
    return Eigen::Vector3d(point.x(), point.y(), 4 + 0.3 * point.x());
  });
  ExpectLocated(Localize(features_));
  options_.solver = "dlt6";
  EXPECT_EQ(Localize(features_).reason, "too_few_inliers");
}

// Among features anywhere near the projections of their landmarks some are inliers, however wrong
// the pose is.
TEST_F(LocalizeTest, InliersByChanceGiveNoPlace) {
  Random random(3);
  for (auto& keypoint : features_.keypoints_px) {
    const double angle_rad = random.Uniform(0, 6.28);
    const double radius_px = 9.5 * std::sqrt(random.Uniform(0, 1));
    keypoint += Eigen::Vector2f(static_cast<float>(radius_px * std::cos(angle_rad)),
                                static_cast<float>(radius_px * std::sin(angle_rad)));
  }
  const QueryResult refused = Localize(features_);
  EXPECT_EQ(refused.verdict, QueryVerdict::kNotInMap);
  EXPECT_EQ(refused.reason, "too_few_inliers");
  options_.min_inlier_significance = 0;
  const QueryResult placed = Localize(features_);
  EXPECT_TRUE(placed.IsLocated());
  EXPECT_GE(placed.num_inliers, options_.min_inliers);
}

TEST_F(LocalizeTest, TwoPlacesThatLookAlikeAreAmbiguous) {
  const LandmarkMap alone = map_;
  AddTwin({Eigen::Quaterniond::Identity(), {20, 0, 0}}, &map_);
  options_.max_ratio = 1;  // or no feature would tell the twins apart
  const QueryResult result = Localize(features_);
  EXPECT_EQ(result.verdict, QueryVerdict::kAmbiguous);
  EXPECT_EQ(result.reason, "rival_place");
  EXPECT_EQ(result.num_rival_inliers, result.num_inliers);
  EXPECT_EQ(result.confidence, 0);
  map_ = alone;
  const QueryResult single = Localize(features_);
  EXPECT_EQ(single.verdict, QueryVerdict::kLocated);
  EXPECT_EQ(single.num_rival_inliers, 0);
  EXPECT_GT(single.confidence, 0.8);
}

// A corridor that looks the same after a half turn: same place, other direction.
TEST_F(LocalizeTest, TheSamePlaceTheOtherWayRoundIsARival) {
  const Rigid3 turn{Eigen::Quaterniond(Eigen::AngleAxisd(3.14159, Eigen::Vector3d::UnitY())),
                    Eigen::Vector3d::Zero()};
  AddTwin(pose_ * turn * pose_.Inverse(), &map_);
  options_.max_ratio = 1;
  EXPECT_EQ(Localize(features_).verdict, QueryVerdict::kAmbiguous);
}

// Without the ratio test between places the words alone find nothing; retrieval parts the places.
TEST_F(LocalizeTest, TwinsAreFoundByRetrieval) {
  AddTwin({Eigen::Quaterniond::Identity(), {20, 0, 0}}, &map_);
  EXPECT_TRUE(Localize(features_).HasPose());
}

TEST_F(LocalizeTest, AMirroredPictureIsNotInTheMap) {
  const QueryResult result = Localize(Mirrored(features_));
  EXPECT_EQ(result.verdict, QueryVerdict::kNotInMap);
  EXPECT_EQ(result.reason, "mirrored");
  EXPECT_FALSE(Localize(Mirrored(features_), {scene_.cameras[0].color, 0.3}).HasPose());
}

// Both the picture and its mirror image are somewhere in the map: the picture counts.
TEST_F(LocalizeTest, APlaceWithAMirroredTwinIsFound) {
  AddTwin({Eigen::Quaterniond::Identity(), {20, 0, 0}}, &map_);
  const std::size_t num_points = scene_.points_in_map.size();
  FrameFeatures twin;
  for (std::size_t i = num_points; i < 2 * num_points; ++i) {
    map_.positions_in_map[i].x() = 20 - scene_.points_in_map[i - num_points].x();
    const std::uint8_t* descriptor = map_.Descriptor(static_cast<int>(i));
    twin.descriptors.insert(twin.descriptors.end(), descriptor, descriptor + 128);
  }
  twin = Mirrored(twin);
  std::ranges::copy(twin.descriptors, &map_.descriptors[128 * num_points]);
  FillWords(vocabulary_.tree, &map_);
  ExpectLocated(Localize(features_));
  const QueryResult twins = Localize(Mirrored(features_));
  ASSERT_TRUE(twins.IsLocated()) << twins.reason;
  EXPECT_GT(twins.map_from_camera.translation.x(), 15);
}

TEST_F(LocalizeTest, AnUncertainPoseIsNotInTheMap) {
  options_.max_position_sigma_m = 0.001;
  const QueryResult result = Localize(features_);
  EXPECT_EQ(result.verdict, QueryVerdict::kNotInMap);
  EXPECT_EQ(result.reason, "uncertain_pose");
  EXPECT_GT(result.position_sigma_m, 0.001);
}

TEST_F(LocalizeTest, SaysWhyNotInTheMap) {
  EXPECT_EQ(Localize(FrameFeatures{}).verdict, QueryVerdict::kNoFeatures);
  Random random(11);
  FrameFeatures foreign = features_;
  foreign.descriptors.clear();
  for (int i = 0; i < foreign.NumFeatures(); ++i) AddRandomDescriptor(random, &foreign);
  EXPECT_EQ(Localize(foreign).reason, "too_few_matches");
  FrameFeatures shuffled = features_;
  std::reverse(shuffled.keypoints_px.begin(), shuffled.keypoints_px.end());
  const QueryResult result = Localize(shuffled);
  EXPECT_EQ(result.verdict, QueryVerdict::kNotInMap);
  EXPECT_EQ(result.reason, "too_few_inliers");
  EXPECT_GT(result.num_matches, 12);
  EXPECT_EQ(result.confidence, 0);
}

TEST_F(LocalizeTest, EveryQueryGetsARow) {
  input_.queries.assign(3, query_);
  input_.queries[1].color.path = "broken.png";
  const auto load_gray = input_.load_color;
  input_.load_color = [&](const FrameRecord& query, const RgbdCamera& camera) {
    if (query.color.path == "broken.png") throw DataError("broken.png: truncated");
    return load_gray(query, camera);
  };
  const auto results = Run(2);
  EXPECT_EQ(problems_, std::vector<std::string>{"broken.png: truncated"});
  ASSERT_EQ(results.size(), 3U);
  EXPECT_EQ(results[0].reason, "no_features");
  EXPECT_EQ(results[1].reason, "unreadable_image");
  EXPECT_EQ(QueriesToCsv(results), QueriesToCsv(Run(1)));
  const auto report = SummarizeQueries(results);
  EXPECT_EQ(report["num_by_verdict"]["located"], 0);
  EXPECT_EQ(report["num_by_verdict"]["no_features"], 2);
  EXPECT_EQ(report["num_not_located_by_reason"]["unreadable_image"], 1);
}

// An empty picture that must be scaled: OpenCV throws. The others go on.
TEST_F(LocalizeTest, AnExceptionOfOpenCvIsOfItsPictureAlone) {
  input_.map_cameras = scene_.cameras;
  input_.cameras.push_back(scene_.cameras[0]);
  input_.cameras[1].color = Camera{2560, 1920, 2080, 2080, 1279.5, 959.5};
  input_.queries.assign(3, query_);
  input_.queries[1].camera_idx = 1;
  const auto load_gray = input_.load_color;
  input_.load_color = [&](const FrameRecord& query, const RgbdCamera& camera) {
    return query.camera_idx == 1 ? ColorImage{} : load_gray(query, camera);
  };
  const auto results = Run(2);
  EXPECT_EQ(results[0].verdict, QueryVerdict::kNoFeatures);
  EXPECT_EQ(results[1].verdict, QueryVerdict::kUnreadable);
  EXPECT_EQ(results[1].reason, "unreadable_image");
  EXPECT_EQ(results[2].verdict, QueryVerdict::kNoFeatures);
  ASSERT_EQ(problems_.size(), 1U);
  EXPECT_THAT(problems_[0], testing::StartsWith("query.png: OpenCV: "));
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

}  // namespace nightmap::localize_test
