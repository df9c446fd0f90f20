// SPDX-License-Identifier: Apache-2.0
// Landmarks of a site that is cut into regions, against those of the same site in one.
#include <algorithm>
#include <set>

#include "tests/landmarks_run.h"

namespace nightmap::landmark_regions_test {

// A corridor, gone along twice, with the noise of a real camera. Every tenth feature has no depth.
// Few of its points look different, so that neighbours compete for features, also across borders.
class LandmarkRegionsTest : public testing::Test {
 protected:
  LandmarkRegionsTest() {
    Random random(11);
    std::vector<std::vector<std::uint8_t>> looks;
    for (int i = 0; i < 12; ++i) looks.push_back(RandomRootSift(random));
    for (int i = 0; i < 4000; ++i) {
      scene_.points_in_map.emplace_back(
          random.Uniform(-3, 21), random.Uniform(-1.5, 3), random.Uniform(3, 6));
      scene_.descriptors.push_back(looks[random.Index(looks.size())]);
    }
    scene_.cameras[0].color = Camera{640, 480, 520, 520, 319.5, 239.5};
    for (int i = 0; i < 120; ++i) {
      AddFrame(ScenePose(0.3 * (i % 60), 0.1 - 0.003 * (i % 60)), &scene_);
      FrameFeatures& features = scene_.features.frames.back();
      for (std::size_t k = 0; k < features.keypoints_px.size(); ++k) {
        features.keypoints_px[k] +=
            0.5F * Eigen::Vector2d(random.Gaussian(), random.Gaussian()).cast<float>();
        features.depths_m[k] *= 1 + 0.01F * static_cast<float>(random.Gaussian());
        if (k % 10 == 0) features.depths_m[k] = 0;
      }
    }
    vocabulary_ = MakeSceneVocabulary(scene_);
  }
  LandmarksInput Input(std::size_t max_region_observers) const {
    return {scene_.frames,
            scene_.cameras,
            SiteFeatures(scene_.features),
            &vocabulary_.tree,
            scene_.poses,
            scene_.poses,
            max_region_observers};
  }
  LandmarksRun Cut(std::size_t max_region_observers, int num_threads = 1) const {
    return RunOnScene(options_, Input(max_region_observers), num_threads);
  }

  LandmarkScene scene_;
  Vocabulary vocabulary_;
  LandmarksOptions options_;
};

Track ObservationsOf(const LandmarkMap& map, std::size_t landmark) {
  Track observations;
  for (std::size_t i = 0; i < map.landmark_keyframes[landmark].size(); ++i) {
    observations.push_back(
        {map.landmark_keyframes[landmark][i], map.landmark_features[landmark][i]});
  }
  return observations;
}

TEST_F(LandmarkRegionsTest, AreNearlyThoseOfOneRegion) {
  const LandmarksRun one = Cut(1000);
  ASSERT_EQ(one.regions.size(), 1U);
  const LandmarksRun many = Cut(12);
  ASSERT_GE(many.regions.size(), 8U);
  std::set<Track> of_one;
  for (std::size_t i = 0; i < one.map.landmark_keyframes.size(); ++i) {
    of_one.insert(ObservationsOf(one.map, i));
  }
  std::size_t num_same = 0;
  for (std::size_t i = 0; i < many.map.landmark_keyframes.size(); ++i) {
    num_same += of_one.contains(ObservationsOf(many.map, i));
  }
  EXPECT_GT(num_same, of_one.size() * 97 / 100);
  EXPECT_LT(num_same, of_one.size()) << "no competition across borders: the scene is too easy";
  EXPECT_NEAR(many.map.NumLandmarks(), one.map.NumLandmarks(), one.map.NumLandmarks() / 100.0);
}

// With so small a margin and so few depths, both sides of many borders want the same feature.
TEST_F(LandmarkRegionsTest, NoTwoLandmarksShowTheSameFeature) {
  options_.tracker.voxel_size_m = 0.03;
  for (FrameFeatures& features : scene_.features.frames) {
    for (std::size_t k = 0; k < features.depths_m.size(); ++k) {
      if (k % 2 == 0) features.depths_m[k] = 0;
    }
  }
  for (const std::size_t max_observers : {1000, 12, 3}) {
    const LandmarksRun run = Cut(max_observers);
    std::set<Sighting> seen;
    for (std::size_t i = 0; i < run.map.landmark_keyframes.size(); ++i) {
      for (const Sighting& sighting : ObservationsOf(run.map, i)) {
        EXPECT_TRUE(seen.insert(sighting).second) << "of " << max_observers;
      }
    }
  }
}

TEST_F(LandmarkRegionsTest, LandmarksLieInTheBoxOfTheirRegion) {
  const LandmarksRun run = Cut(12);
  std::size_t landmark = 0;
  for (const LandmarkRegion& region : run.regions) {
    for (std::int64_t i = 0; i < region.num_landmarks; ++i, ++landmark) {
      EXPECT_TRUE(region.box.Contains(run.map.positions_in_map[landmark].head<2>()));
    }
  }
  EXPECT_EQ(landmark, run.map.positions_in_map.size());
}

TEST_F(LandmarkRegionsTest, AreTheSameForAnyNumberOfThreads) {
  const LandmarkMap one = Cut(12, 1).map;
  const LandmarkMap four = Cut(12, 4).map;
  EXPECT_EQ(one.positions_in_map, four.positions_in_map);
  EXPECT_EQ(one.words, four.words);
  EXPECT_EQ(one.landmark_keyframes, four.landmark_keyframes);
  EXPECT_EQ(one.landmark_features, four.landmark_features);
}

TEST_F(LandmarkRegionsTest, ShareTheLargestNumberByTheirObservers) {
  options_.max_landmarks = 1200;
  const LandmarksRun run = Cut(12);
  EXPECT_EQ(run.map.NumLandmarks(), 1200);
  EXPECT_GT(run.figures.num_found, 2500U);
  for (const LandmarkRegion& region : run.regions) {
    EXPECT_GE(region.num_landmarks, 1200 * 6 / 120 - 1);
    EXPECT_LE(region.num_landmarks, 1200 * 12 / 120 + 1);
  }
}

}  // namespace nightmap::landmark_regions_test
