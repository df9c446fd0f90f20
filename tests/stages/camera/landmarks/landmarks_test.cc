// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/landmarks.h"

#include <map>
#include <set>

#include "stages/camera/landmarks/landmarks_report.h"
#include "tests/landmarks_run.h"

namespace nightmap::landmarks_test {

class LandmarksTest : public testing::Test {
 protected:
  LandmarkMap Run(int num_threads = 1) const { return RunAll(num_threads).map; }
  LandmarksRun RunAll(int num_threads = 1, std::size_t max_region_observers = 1000) const {
    const LandmarksInput input{scene_.frames,
                               scene_.cameras,
                               SiteFeatures(scene_.features),
                               &vocabulary_.tree,
                               scene_.poses,
                               keyframes_,
                               max_region_observers};
    return RunOnScene(options_, input, num_threads);
  }
  // The scene's point nearest to a landmark.
  int PointOf(const LandmarkMap& map, int landmark) const {
    const Eigen::Vector3d& position = map.positions_in_map[static_cast<std::size_t>(landmark)];
    int best = 0;
    for (int i = 0; i < static_cast<int>(scene_.points_in_map.size()); ++i) {
      if ((Point(i) - position).norm() < (Point(best) - position).norm()) best = i;
    }
    return best;
  }
  const Eigen::Vector3d& Point(int i) const {
    return scene_.points_in_map[static_cast<std::size_t>(i)];
  }
  // Point -> frames that see it.
  std::map<int, std::vector<int>> TrueVisibility() const {
    std::map<int, std::vector<int>> frames;
    for (std::size_t frame = 0; frame < scene_.frame_points.size(); ++frame) {
      for (const int point : scene_.frame_points[frame]) {
        frames[point].push_back(static_cast<int>(frame));
      }
    }
    return frames;
  }

  LandmarkScene scene_ = MakeLandmarkScene();
  Vocabulary vocabulary_ = MakeSceneVocabulary(scene_);
  std::vector<StampedPose> keyframes_ = scene_.poses;
  LandmarksOptions options_;
};

TEST_F(LandmarksTest, RecoversEveryPointOnce) {
  const LandmarkMap map = Run();
  const auto truth = TrueVisibility();
  EXPECT_EQ(map.NumLandmarks(), static_cast<int>(truth.size()));
  std::set<int> points;
  for (int i = 0; i < map.NumLandmarks(); ++i) {
    const int point = PointOf(map, i);
    EXPECT_TRUE(points.insert(point).second);
    EXPECT_NEAR((map.positions_in_map[static_cast<std::size_t>(i)] - Point(point)).norm(), 0, 1e-4);
    EXPECT_EQ(map.landmark_keyframes[static_cast<std::size_t>(i)], truth.at(point));
  }
}

TEST_F(LandmarksTest, CarriesDescriptorsAndTheirWords) {
  const LandmarkMap map = Run();
  for (int i = 0; i < map.NumDescriptors(); i += 17) {
    const int point = PointOf(map, map.descriptor_landmarks[static_cast<std::size_t>(i)]);
    const auto& descriptor = scene_.descriptors[static_cast<std::size_t>(point)];
    EXPECT_TRUE(std::equal(descriptor.begin(), descriptor.end(), map.Descriptor(i)));
    for (int level = 1; level <= vocabulary_.tree.Depth(); ++level) {
      EXPECT_EQ(map.Word(i, level), vocabulary_.tree.Word(descriptor.data(), level));
    }
  }
}

TEST_F(LandmarksTest, KeepsOnlyWhatIsSeenOftenEnough) {
  options_.min_observations = 3;
  int num_expected = 0;
  for (const auto& [point, frames] : TrueVisibility()) num_expected += frames.size() >= 3;
  EXPECT_EQ(Run().NumLandmarks(), num_expected);
  EXPECT_LT(num_expected, static_cast<int>(TrueVisibility().size()));
}

TEST_F(LandmarksTest, KeepsTheMostSeenOfTooMany) {
  options_.max_landmarks = 20;
  const LandmarkMap map = Run();
  EXPECT_EQ(map.NumLandmarks(), 20);
  for (const auto& keyframes : map.landmark_keyframes) {
    EXPECT_EQ(keyframes.size(), scene_.frames.size());
  }
}

// A second room, 40 m off, that two frames come by in the end.
TEST_F(LandmarksTest, TheRoomSeenLastAndLeastKeepsItsShare) {
  const std::size_t num_first = scene_.frames.size();
  const LandmarkScene other = MakeLandmarkScene();
  for (std::size_t i = 0; i < other.points_in_map.size(); ++i) {
    scene_.points_in_map.push_back(other.points_in_map[i] + Eigen::Vector3d(40, 0, 0));
    scene_.descriptors.push_back(other.descriptors[i]);
  }
  for (const int i : {0, 1}) {
    Rigid3 pose = other.poses[static_cast<std::size_t>(i)].pose;
    pose.translation.x() += 40;
    AddFrame(pose, &scene_);
  }
  keyframes_ = scene_.poses;
  const LandmarksRun all = RunAll();
  EXPECT_EQ(all.figures.NumDropped(), 0U);
  EXPECT_EQ(DroppedLandmarks(all.figures), "");
  options_.max_landmarks = all.map.NumLandmarks() / 2;
  const LandmarksRun half = RunAll();
  EXPECT_EQ(half.map.NumLandmarks(), options_.max_landmarks);
  const auto before = all.map.KeyframeLandmarks(), after = half.map.KeyframeLandmarks();
  for (std::size_t i = 0; i < scene_.frames.size(); ++i) {
    const double kept =
        static_cast<double>(after[i].size()) / static_cast<double>(before[i].size());
    EXPECT_GT(kept, 0.4) << "frame " << i << (i < num_first ? " of the first" : " of the other");
  }
  const auto report = SummarizeLandmarks(half.figures);
  EXPECT_EQ(report.at("num_landmarks_found"), all.map.NumLandmarks());
  EXPECT_EQ(report.at("num_dropped_by_max_landmarks"),
            all.map.NumLandmarks() - options_.max_landmarks);
  EXPECT_THAT(DroppedLandmarks(half.figures), testing::HasSubstr("landmarks.toml"));
}

// Frame 3 measures every depth 4 % too far. The plain mean of eight observations would move by an
// eighth of that; the pixels of the others, seen from the side, must hold the point better.
TEST_F(LandmarksTest, WeighsDirectionsByTheirNoise) {
  for (float& depth_m : scene_.features.frames[3].depths_m) depth_m *= 1.04F;
  options_.min_observations = 8;
  const LandmarkMap map = Run();
  ASSERT_GT(map.NumLandmarks(), 20);
  for (int i = 0; i < map.NumLandmarks(); ++i) {
    const Eigen::Vector3d error =
        map.positions_in_map[static_cast<std::size_t>(i)] - Point(PointOf(map, i));
    EXPECT_LT(error.norm(), 0.7 * 0.04 * Point(PointOf(map, i)).z() / 8.0);
  }
}

TEST_F(LandmarksTest, ObservesWithoutDepth) {
  std::fill(
      scene_.features.frames[5].depths_m.begin(), scene_.features.frames[5].depths_m.end(), 0.0F);
  // Without any depth a frame does not know where to look.
  scene_.features.frames[5].depths_m[0] =
      static_cast<float>((scene_.poses[5].pose.Inverse() * Point(scene_.frame_points[5][0])).z());
  options_.tracker.voxel_size_m = 10.0;
  const LandmarkMap map = Run();
  EXPECT_GT(map.KeyframeLandmarks()[5].size(), scene_.frame_points[5].size() * 9 / 10);
}

TEST_F(LandmarksTest, FramesThatAreNoKeyframesObserveOnRequest) {
  keyframes_ = {scene_.poses[0], scene_.poses[4]};
  EXPECT_EQ(Run().keyframes.size(), 2U);
  EXPECT_EQ(Run().keyframes[1].frame_idx, 4);
  options_.observers = "all";
  EXPECT_EQ(Run().keyframes.size(), 8U);
}

TEST_F(LandmarksTest, IsTheSameForOneAndTwoThreads) {
  const LandmarkMap one = Run(1);
  const LandmarkMap two = Run(2);
  EXPECT_EQ(one.positions_in_map, two.positions_in_map);
  EXPECT_EQ(one.descriptors, two.descriptors);
  EXPECT_EQ(one.words, two.words);
  EXPECT_EQ(one.landmark_keyframes, two.landmark_keyframes);
}

TEST_F(LandmarksTest, RefusesPosesOfAnotherSite) {
  keyframes_[2].time_ns += 1;
  NIGHTMAP_EXPECT_ERROR(DataError, Run(), "time of no frame");
}

TEST_F(LandmarksTest, RefusesFeaturesOfOtherFrames) {
  scene_.features.frames.pop_back();
  NIGHTMAP_EXPECT_ERROR(DataError, Run(), "not of the listed frames");
}

}  // namespace nightmap::landmarks_test
