// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/global_bundle.h"

#include <algorithm>
#include <limits>
#include <map>

#include "stages/camera/adjust/adjust_output.h"
#include "tests/failing_cholmod.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::global_bundle_test {

// The scene's frames as keyframes of two cameras in turn; the second one measures depth 4 % short.
struct TwoCameras {
  AdjustInput input;
  std::vector<Track> tracks;
  std::map<int, Rigid3> poses;
};

TwoCameras MakeTwoCameras() {
  LandmarkScene scene = MakeLandmarkScene();
  TwoCameras two;
  two.input.frames = scene.frames;
  two.input.cameras = {scene.cameras[0], scene.cameras[0]};
  std::map<int, Track> tracks;
  for (std::size_t i = 0; i < scene.frames.size(); ++i) {
    const int frame_idx = static_cast<int>(i);
    two.input.frames[i].camera_idx = frame_idx % 2;
    for (float& depth_m : scene.features.frames[i].depths_m) {
      if (frame_idx % 2 == 1) depth_m *= 0.96F;
    }
    for (std::size_t k = 0; k < scene.frame_points[i].size(); ++k) {
      tracks[scene.frame_points[i][k]].push_back({frame_idx, static_cast<int>(k)});
    }
    two.poses[frame_idx] = scene.poses[i].pose;
  }
  two.input.features = SiteFeatures(scene.features);
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
  const BundleOptions bundle_options{.max_iterations = 50, .depth = DepthCalibration::kScale};
  TwoCameras two = MakeTwoCameras();
  const auto summary = AdjustFrames(two.input, bundle_options, two.tracks, {}, &two.poses);
  ASSERT_EQ(summary.calibrations.size(), 2U);
  EXPECT_EQ(summary.calibrations[0].depth_scale, 1);
  EXPECT_NEAR(summary.calibrations[1].depth_scale, 1 / 0.96, 1e-3);
  EXPECT_LT(WorstError_m(two, MakeLandmarkScene()), 1e-3);
}

TEST(GlobalBundle, ADepthScaleIsOneUnlessAsked) {
  TwoCameras two = MakeTwoCameras();
  const auto summary = AdjustFrames(two.input, {}, two.tracks, {}, &two.poses);
  EXPECT_EQ(summary.calibrations[0].depth_scale, 1);
  EXPECT_EQ(summary.calibrations[1].depth_scale, 1);
  EXPECT_GT(WorstError_m(two, MakeLandmarkScene()), 1e-3) << "the bias must show somewhere";
}

TEST(GlobalBundle, WithoutMemoryItIsAnErrorAndNoUnadjustedMap) {
  TwoCameras two = MakeTwoCameras();
  const FailingCholmod without_memory(2000);
  NIGHTMAP_EXPECT_ERROR(DataError,
                        AdjustFrames(two.input, {}, two.tracks, {}, &two.poses),
                        "does not fit into memory");
}

TEST(GlobalBundle, TheReportSaysHowEachAdjustmentEnded) {
  TwoCameras two = MakeTwoCameras();
  AdjustResult result;
  result.adjustments =
      AdjustFrames(two.input, {.max_iterations = 1}, two.tracks, {}, &two.poses).adjustments;
  const auto told = Summarize({}, two.input, result).at("bundle_adjustments");
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0].at("end"), "max_iterations reached");
  EXPECT_EQ(told[0].at("num_iterations"), 1);
  EXPECT_GT(told[0].at("initial_cost"), told[0].at("final_cost"));
}

TEST(GlobalBundle, TheReportSaysWhatIsKnownOfTheCameras) {
  AdjustOptions options;
  AdjustResult result;
  const auto told = [&](const char* what) { return Summarize(options, {}, result).at(what); };
  EXPECT_EQ(told("calibrations"), "not estimated");
  result.calibrations = {{}, {1.01, 0.02, 1.04}};
  EXPECT_EQ(told("depth_scales"), "not estimated");
  EXPECT_EQ(told("calibrations")[1],
            (nlohmann::json{{"focal_scale", 1.01}, {"rolling_shutter_readout_s", 0.02}}));
  options.estimate_depth_scales = true;
  EXPECT_EQ(told("depth_scales"), (nlohmann::json{1, 1.04}));
  result.calibrations.pop_back();
  EXPECT_NE(told("depth_scales").get<std::string>().find("one unknown"), std::string::npos);
  options.calibrate = false;
  EXPECT_EQ(told("calibrations"), "not estimated");
  EXPECT_EQ(told("depth_offsets"), "not estimated");
  result.depth_offsets = {{0.03}, {0.002}};
  EXPECT_EQ(told("depth_offsets")[0], (nlohmann::json{{"offset_m", 0.03}, {"sigma_m", 0.002}}));
  result.depth_offsets.sigma_m[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(told("depth_offsets"), "not estimated");
}

TEST(GlobalBundle, TheFocalLengthFoundGoesIntoTheCameras) {
  const TwoCameras two = MakeTwoCameras();
  AdjustResult result;
  EXPECT_EQ(CalibratedCameras(two.input, result)[1].color, two.input.cameras[1].color);
  result.calibrations = {{}, {1.01, 0.02, 1}};
  const auto cameras = CalibratedCameras(two.input, result);
  EXPECT_EQ(cameras[0].color, two.input.cameras[0].color);
  EXPECT_DOUBLE_EQ(cameras[1].color.fx, 1.01 * two.input.cameras[1].color.fx);
}

}  // namespace nightmap::global_bundle_test
