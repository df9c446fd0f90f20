// SPDX-License-Identifier: Apache-2.0
#include "stages/landmarks/colmap_export.h"

#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

class ColmapExportTest : public testing::Test {
 protected:
  // The pictures as a distorting camera takes them; keypoints stay where they are without
  // distortion.
  ColmapExportTest() {
    Camera& camera = scene_.cameras[0].color;
    camera.k1 = -0.1;
    camera.k2 = 0.02;
    camera.p1 = 0.001;
    camera.k3 = 0.003;
    for (FrameFeatures& features : scene_.features.frames) {
      for (std::size_t i = 0; i < features.keypoints_px.size(); ++i) {
        const Eigen::Vector2d keypoint = features.keypoints_px[i].cast<double>();
        const auto raw = camera.Project(camera.BackProjectUndistorted(keypoint, 1.0));
        features.raw_keypoints_px[i] = raw.value().cast<float>();
      }
    }
  }
  LandmarksInput Input() const {
    const std::vector<StampedPose> keyframes(scene_.poses.begin() + 2, scene_.poses.end());
    return {
        scene_.frames, scene_.cameras, scene_.features, &vocabulary_.tree, scene_.poses, keyframes};
  }
  LandmarkMap Map() const {
    Progress progress("landmarks", false);
    return RunLandmarks({}, Input(), progress, 1);
  }

  LandmarkScene scene_ = MakeLandmarkScene();
  Vocabulary vocabulary_ = MakeSceneVocabulary(scene_);
};

TEST_F(ColmapExportTest, FitsThePicturesAsTheyAre) {
  const ColmapModel model = MakeColmapModel(Input(), Map());
  ASSERT_EQ(model.images.size(), scene_.frames.size() - 2);
  EXPECT_EQ(model.cameras[0].k3, scene_.cameras[0].color.k3);
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const FrameFeatures& features = scene_.features.frames[i + 2];
    ASSERT_EQ(model.images[i].keypoints_px.size(), features.raw_keypoints_px.size());
    EXPECT_EQ(model.images[i].descriptors, features.descriptors);
    EXPECT_EQ(model.images[i].keypoints_px[5], features.raw_keypoints_px[5].cast<double>());
  }
  EXPECT_GT(model.MeanReprojectionError_px(), 0);
  EXPECT_LT(model.MeanReprojectionError_px(), 0.02);
}

TEST_F(ColmapExportTest, TracksAndKeypointsNameEachOther) {
  const LandmarkMap map = Map();
  const ColmapModel model = MakeColmapModel(Input(), map);
  ASSERT_EQ(static_cast<int>(model.points.size()), map.NumLandmarks());
  std::size_t num_observations = 0;
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    EXPECT_EQ(model.points[i].track.size(), map.landmark_keyframes[i].size());
    for (const ColmapObservation& seen : model.points[i].track) {
      const ColmapImage& image = model.images[static_cast<std::size_t>(seen.image_idx)];
      EXPECT_EQ(image.keypoint_points[static_cast<std::size_t>(seen.keypoint)],
                static_cast<int>(i));
      ++num_observations;
    }
  }
  std::size_t num_pointing = 0;
  for (const ColmapImage& image : model.images) {
    for (const int point : image.keypoint_points) num_pointing += point >= 0 ? 1 : 0;
  }
  EXPECT_EQ(num_pointing, num_observations);
}

TEST_F(ColmapExportTest, TheErrorIsTakenInThePicture) {
  LandmarkMap map = Map();
  const ColmapModel before = MakeColmapModel(Input(), map);
  // One observation of the first landmark is moved by 3 px.
  const auto frame = static_cast<std::size_t>(
      map.keyframes[static_cast<std::size_t>(map.landmark_keyframes[0][0])].frame_idx);
  const auto feature = static_cast<std::size_t>(map.landmark_features[0][0]);
  scene_.features.frames[frame].raw_keypoints_px[feature].x() += 3;
  const ColmapModel after = MakeColmapModel(Input(), map);
  const auto num_seen = static_cast<double>(map.landmark_keyframes[0].size());
  EXPECT_NEAR(after.points[0].error_px, before.points[0].error_px + 3 / num_seen, 0.1 / num_seen);
}

TEST_F(ColmapExportTest, WhatCannotBeSeenIsNoObservation) {
  LandmarkMap map = Map();
  map.positions_in_map[0].z() = -100;  // behind every camera
  const ColmapModel model = MakeColmapModel(Input(), map);
  EXPECT_TRUE(model.points[0].track.empty());
  EXPECT_EQ(model.points[0].error_px, 0);
}

TEST_F(ColmapExportTest, OnlyRootSiftGivesDescriptors) {
  LandmarkMap map = Map();
  map.kind = DescriptorKind::kOrb;
  EXPECT_TRUE(MakeColmapModel(Input(), map).images[0].descriptors.empty());
}

}  // namespace
}  // namespace nightmap
