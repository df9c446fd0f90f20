// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/colmap_export.h"

#include "tests/landmarks_run.h"

namespace nightmap::colmap_export_test {

ColmapModel MakeColmapModel(const LandmarksInput& input, const LandmarkMap& map) {
  ColmapModel model = StartColmapModel(input, map);
  AddColmapPoints(map, &model);
  return model;
}

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
    return {scene_.frames,
            scene_.cameras,
            SiteFeatures(scene_.features),
            &vocabulary_.tree,
            scene_.poses,
            keyframes};
  }
  LandmarkMap Map() const { return RunOnScene({}, Input()).map; }

  LandmarkScene scene_ = MakeLandmarkScene();
  Vocabulary vocabulary_ = MakeSceneVocabulary(scene_);
};

TEST_F(ColmapExportTest, FitsThePicturesAsTheyAre) {
  const ColmapModel model = MakeColmapModel(Input(), Map());
  ASSERT_EQ(model.images.size(), scene_.frames.size() - 2);
  EXPECT_EQ(model.cameras[0].k3, scene_.cameras[0].color.k3);
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const FrameFeatures& features = scene_.features.frames[i + 2];
    const ColmapFeatures of_image = model.features(i);
    ASSERT_EQ(of_image.keypoints_px.size(), features.raw_keypoints_px.size());
    EXPECT_EQ(of_image.descriptors, features.descriptors);
    EXPECT_EQ(of_image.keypoints_px[5], features.raw_keypoints_px[5].cast<double>());
  }
  EXPECT_GT(model.MeanReprojectionError_px(), 0);
  EXPECT_LT(model.MeanReprojectionError_px(), 0.02);
}

TEST_F(ColmapExportTest, FitsThePicturesAsStored) {
  const LandmarkMap map = Map();
  const ColmapModel seen = MakeColmapModel(Input(), map);
  RgbdCamera& camera = scene_.cameras[0];
  camera.picture_width = 3 * camera.color.width;
  camera.picture_height = 3 * camera.color.height;
  const ColmapModel stored = MakeColmapModel(Input(), map);
  EXPECT_EQ(stored.cameras[0].width, camera.picture_width);
  EXPECT_NEAR(stored.MeanReprojectionError_px(), 3 * seen.MeanReprojectionError_px(), 1e-6);
  EXPECT_NEAR(stored.features(1).keypoints_px[5].x(),
              3 * (seen.features(1).keypoints_px[5].x() + 0.5) - 0.5,
              1e-6);
}

TEST_F(ColmapExportTest, TracksAndKeypointsNameEachOther) {
  const LandmarkMap map = Map();
  const ColmapModel model = MakeColmapModel(Input(), map);
  std::size_t point = 0;
  std::size_t num_observations = 0;
  for (std::size_t i = 0; i < map.landmark_keyframes.size(); ++i) {
    const std::size_t num_seen = map.landmark_keyframes[i].size();
    if (num_seen < 2) continue;  // no point of COLMAP's
    ASSERT_LT(point, model.points.size());
    EXPECT_EQ(model.points[point].position_in_map, map.positions_in_map[i]);
    const auto track = model.TrackOf(model.points[point]);
    EXPECT_EQ(track.size(), num_seen);
    for (const ColmapObservation& seen : track) {
      const ColmapImage& image = model.images[static_cast<std::size_t>(seen.image_idx)];
      const auto keypoint = static_cast<std::size_t>(seen.keypoint);
      EXPECT_EQ(image.keypoint_points[keypoint], static_cast<int>(point));
    }
    num_observations += num_seen;
    ++point;
  }
  EXPECT_EQ(point, model.points.size());
  EXPECT_LT(point, map.landmark_keyframes.size());
  std::size_t num_pointing = 0;
  for (const ColmapImage& image : model.images) {
    for (const int named : image.keypoint_points) num_pointing += named >= 0 ? 1 : 0;
  }
  EXPECT_EQ(num_pointing, num_observations);
}

TEST_F(ColmapExportTest, RegionsGiveThePointsOfTheWholeMap) {
  const LandmarksInput input = Input();
  const LandmarkMap map = Map();
  const ColmapModel whole = MakeColmapModel(input, map);
  LandmarksInput cut = input;
  cut.max_region_observers = 2;
  LandmarksOptions fine;
  fine.tracker.voxel_size_m = 0.05;
  ColmapModel model = StartColmapModel(input, map);
  std::size_t num_regions = 0;
  const auto add = [&](const Rectangle&, const LandmarkMap& region) {
    ++num_regions;
    AddColmapPoints(region, &model);
  };
  RunLandmarks(fine, cut, add, NoProgress(), 1);
  EXPECT_GT(num_regions, 1U);
  EXPECT_EQ(model.points.size(), whole.points.size());
  EXPECT_EQ(model.observations.size(), whole.observations.size());
  EXPECT_NEAR(model.MeanReprojectionError_px(), whole.MeanReprojectionError_px(), 1e-9);
}

// A landmark that several keyframes see.
std::size_t FirstSeenOften(const LandmarkMap& map) {
  std::size_t i = 0;
  while (map.landmark_keyframes.at(i).size() < 3) ++i;
  return i;
}

// Sum of the points' errors.
double TotalError_px(const ColmapModel& model) {
  return model.MeanReprojectionError_px() * static_cast<double>(model.points.size());
}

TEST_F(ColmapExportTest, TheErrorIsTakenInThePicture) {
  const LandmarkMap map = Map();
  const std::size_t landmark = FirstSeenOften(map);
  const double before_px = TotalError_px(MakeColmapModel(Input(), map));
  const auto keyframe = static_cast<std::size_t>(map.landmark_keyframes[landmark][0]);
  const auto frame = static_cast<std::size_t>(map.keyframes[keyframe].frame_idx);
  const auto feature = static_cast<std::size_t>(map.landmark_features[landmark][0]);
  scene_.features.frames[frame].raw_keypoints_px[feature].x() += 3;
  const double after_px = TotalError_px(MakeColmapModel(Input(), map));
  const auto num_seen = static_cast<double>(map.landmark_keyframes[landmark].size());
  EXPECT_NEAR(after_px - before_px, 3 / num_seen, 0.1 / num_seen);
}

TEST_F(ColmapExportTest, WhatCannotBeSeenIsNoPoint) {
  LandmarkMap map = Map();
  const std::size_t num_points = MakeColmapModel(Input(), map).points.size();
  map.positions_in_map[FirstSeenOften(map)].z() = -100;  // behind every camera
  EXPECT_EQ(MakeColmapModel(Input(), map).points.size(), num_points - 1);
}

TEST_F(ColmapExportTest, OnlyRootSiftGivesDescriptors) {
  LandmarkMap map = Map();
  map.kind = DescriptorKind::kOrb;
  EXPECT_TRUE(StartColmapModel(Input(), map).features(0).descriptors.empty());
}

}  // namespace nightmap::colmap_export_test
