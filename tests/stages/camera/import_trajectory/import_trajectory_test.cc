// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/import_trajectory/import_trajectory.h"

#include "tests/test_data.h"

namespace nightmap::import_trajectory_test {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

// A camera that walks along x at 0.3 m per s, with a frame each tenth of a second.
std::vector<FrameRecord> FramesOf(int count) {
  std::vector<FrameRecord> frames;
  for (int i = 0; i < count; ++i) frames.push_back({i, i * kSecond_ns / 10, 0, 0, {}, {}, {}});
  return frames;
}

std::vector<StampedPose> Given(std::int64_t step_ns, std::int64_t end_ns) {
  std::vector<StampedPose> poses;
  for (std::int64_t time_ns = 0; time_ns <= end_ns; time_ns += step_ns) {
    const double x_m = 0.3 * static_cast<double>(time_ns) / static_cast<double>(kSecond_ns);
    poses.push_back({time_ns, {Eigen::Quaterniond::Identity(), {x_m, 0, 0}}});
  }
  return poses;
}

// The number of frames that got a pose, unless they are too few.
std::size_t Judge(const ImportTrajectoryOptions& options,
                  const std::vector<FrameRecord>& frames,
                  const std::vector<StampedPose>& given) {
  const std::size_t num_posed = RunImportTrajectory(options, frames, given).poses.size();
  JudgeNumPosed(options, frames, given, num_posed, "x.tum");
  return num_posed;
}

TEST(ImportTrajectory, FramesGetThePoseOfTheirTime) {
  const auto result = RunImportTrajectory({}, FramesOf(50), Given(kSecond_ns / 15, 5 * kSecond_ns));
  ASSERT_EQ(result.poses.size(), 50U);
  for (std::size_t i = 0; i < result.poses.size(); ++i) {
    EXPECT_NEAR(result.poses[i].pose.translation.x(), 0.03 * static_cast<double>(i), 1e-6);
  }
}

TEST(ImportTrajectory, KeyframesAreAsFarApartAsAsked) {
  ImportTrajectoryOptions options;
  options.keyframe_distance_m = 0.1;
  const auto result =
      RunImportTrajectory(options, FramesOf(50), Given(kSecond_ns / 10, 5 * kSecond_ns));
  ASSERT_GT(result.keyframes.size(), 10U);
  for (std::size_t i = 1; i < result.keyframes.size(); ++i) {
    const auto& a = result.keyframes[i - 1].pose.translation;
    const auto& b = result.keyframes[i].pose.translation;
    EXPECT_NEAR((b - a).norm(), 0.12, 1e-6);
  }
}

TEST(ImportTrajectory, FramesInAGapHaveNoPoseAndTooManyAreRefused) {
  ImportTrajectoryOptions options;
  const auto half = Given(kSecond_ns / 10, 2 * kSecond_ns);
  options.min_posed_ratio = 0.4;
  EXPECT_EQ(Judge(options, FramesOf(50), half), 21U);
  options.min_posed_ratio = 0.5;
  NIGHTMAP_EXPECT_ERROR(ThresholdError,
                        Judge(options, FramesOf(50), half),
                        "x.tum: gives a pose to 21 of 50 frames, fewer than min_posed_ratio = 0.5; "
                        "only 21 frames are within its times");
  options.min_posed_ratio = 0;
  NIGHTMAP_EXPECT_ERROR(ThresholdError, Judge(options, FramesOf(50), {}), "0 of 50 frames");
}

TEST(ImportTrajectory, PosesTooFarApartToInterpolateAreToldFromTimesOfAnotherRecording) {
  ImportTrajectoryOptions options;
  const auto third = Given(3 * kSecond_ns / 10, 5 * kSecond_ns);
  NIGHTMAP_EXPECT_ERROR(ThresholdError,
                        Judge(options, FramesOf(50), third),
                        "x.tum: gives a pose to 17 of 50 frames, fewer than min_posed_ratio = 0.5; "
                        "32 more are between poses over 0.1 s apart");
  options.min_posed_ratio = 0;  // as the message says
  EXPECT_EQ(Judge(options, FramesOf(50), third), 17U);
}

}  // namespace nightmap::import_trajectory_test
