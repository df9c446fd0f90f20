// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/global_bundle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "stages/pose_graph/pose_graph_output.h"
#include "tests/landmark_scene.h"

namespace nightmap {
namespace {

// The scene's frames as keyframes of two cameras in turn; the second one measures depth 4 % short.
struct TwoCameras {
  PoseGraphInput input;
  std::vector<Track> tracks;
  std::map<int, Rigid3> poses;
};

TwoCameras MakeTwoCameras() {
  const LandmarkScene scene = MakeLandmarkScene();
  TwoCameras two;
  two.input.frames = scene.frames;
  two.input.features = scene.features;
  two.input.cameras = {scene.cameras[0], scene.cameras[0]};
  std::map<int, Track> tracks;
  for (std::size_t i = 0; i < scene.frames.size(); ++i) {
    const int frame_idx = static_cast<int>(i);
    two.input.frames[i].camera_idx = frame_idx % 2;
    for (float& depth_m : two.input.features.frames[i].depths_m) {
      if (frame_idx % 2 == 1) depth_m *= 0.96F;
    }
    for (std::size_t k = 0; k < scene.frame_points[i].size(); ++k) {
      tracks[scene.frame_points[i][k]].push_back({frame_idx, static_cast<int>(k)});
    }
    two.poses[frame_idx] = scene.poses[i].pose;
  }
  for (auto& [point, track] : tracks) {
    if (track.size() > 1) two.tracks.push_back(std::move(track));
  }
  return two;
}

double WorstError_m(const TwoCameras& two, const LandmarkScene& truth) {
  double worst = 0;
  for (const auto& [frame_idx, pose] : two.poses) {
    const Rigid3& true_pose = truth.poses[static_cast<std::size_t>(frame_idx)].pose;
    worst = std::max(worst, (pose.translation - true_pose.translation).norm());
  }
  return worst;
}

TEST(GlobalBundle, FindsTheDepthScaleOfTheCameraThatMeasuresShort) {
  PoseGraphOptions options;
  options.estimate_depth_scales = true;
  options.bundle_iterations = 50;
  TwoCameras two = MakeTwoCameras();
  const auto summary = AdjustKeyframes(options, two.input, two.tracks, &two.poses);
  ASSERT_EQ(summary.depth_scales.size(), 2U);
  EXPECT_EQ(summary.depth_scales[0], 1);
  EXPECT_NEAR(summary.depth_scales[1], 1 / 0.96, 1e-3);
  EXPECT_LT(WorstError_m(two, MakeLandmarkScene()), 1e-3);
}

TEST(GlobalBundle, ADepthScaleIsOneUnlessAsked) {
  TwoCameras two = MakeTwoCameras();
  const auto summary = AdjustKeyframes({}, two.input, two.tracks, &two.poses);
  EXPECT_EQ(summary.depth_scales, (std::vector<double>{1, 1}));
  EXPECT_GT(WorstError_m(two, MakeLandmarkScene()), 1e-3) << "the bias must show somewhere";
}

TEST(GlobalBundle, TheReportSaysWhatIsKnownOfTheDepthScales) {
  PoseGraphResult result;
  const auto told = [&] { return Summarize({}, result).at("depth_scales"); };
  EXPECT_EQ(told(), "not estimated");
  result.depth_scales = {1, 1.04};
  EXPECT_EQ(told(), (nlohmann::json{1, 1.04}));
  result.depth_scales = {1};
  EXPECT_NE(told().get<std::string>().find("one unknown"), std::string::npos);
}

}  // namespace
}  // namespace nightmap
