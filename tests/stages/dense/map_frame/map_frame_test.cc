// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/map_frame.h"

#include <gtest/gtest.h>

#include <numbers>

#include "pipeline/base/error.h"
#include "stages/dense/map_frame/describe_floor.h"
#include "tests/stages/dense/map_frame/level_camera.h"
#include "tests/test_data.h"

namespace nightmap::map_frame_test {

constexpr int kNumFrames = 12;
constexpr double kHeight_m = 1.1;

// Cameras pitched down above a level floor that fills their pictures, in a rotated frame.
MapFrameInput MakeInput(const Rigid3& given_from_level) {
  constexpr double kPitch_rad = 0.6;
  MapFrameInput input;
  input.cameras = {RgbdCamera{}};
  input.cameras[0].color = Camera{96, 72, 100, 100, 47.5, 35.5};
  for (int i = 0; i < kNumFrames; ++i) {
    FrameRecord frame;
    frame.frame_idx = i;
    frame.time_ns = 1'000'000'000LL * (i + 1);
    frame.depth.path = "depth.png";
    input.frames.push_back(frame);
    if (i % 2 == 0) {
      input.keyframes.push_back(
          {frame.time_ns, given_from_level * Looking(0.1 * i, kHeight_m, kPitch_rad)});
    }
  }
  input.load_depth = [](const FrameRecord&) {
    DepthImage depth{96, 72, 1, std::vector<float>(static_cast<std::size_t>(96 * 72))};
    for (int y = 0; y < 72; ++y) {
      const double down = std::sin(kPitch_rad) + (y - 35.5) / 100 * std::cos(kPitch_rad);
      for (int x = 0; x < 96; ++x) {
        const double noise = 0.004 * ((x / 12 + y / 12) % 3 - 1);
        depth.At(x, y) = static_cast<float>((1 + noise) * kHeight_m / down);
      }
    }
    return depth;
  };
  return input;
}

Rigid3 Turned() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(1, Eigen::Vector3d(1, 2, -1).normalized())),
          {1, 2, 3}};
}

TEST(MapFrame, PutsTheFloorThatDepthShowsAtZero) {
  const MapFrame frame = RunMapFrame({}, MakeInput(Turned()), 1);
  EXPECT_EQ(frame.floor_source, "floor plane");
  EXPECT_EQ(frame.floor_num_keyframes, kNumFrames / 2);
  EXPECT_NEAR(frame.camera_height_m, kHeight_m, 0.01);
  EXPECT_NEAR((frame.map_from_given * (Turned() * Eigen::Vector3d(2, 1, 0))).z(), 0, 0.01);
}

TEST(MapFrame, IsTheSameAtAnyNumberOfThreads) {
  const MapFrameInput input = MakeInput(Turned());
  EXPECT_EQ(Summarize(RunMapFrame({}, input, 1)), Summarize(RunMapFrame({}, input, 4)));
}

TEST(MapFrame, UnreadableDepthIsSeenByOtherKeyframes) {
  MapFrameInput input = MakeInput(Turned());
  input.frames[0].depth.path = "damaged.png";
  input.load_depth = [good = input.load_depth](const FrameRecord& frame) {
    if (frame.depth.path == "damaged.png") throw DataError("damaged.png");
    return good(frame);
  };
  EXPECT_EQ(RunMapFrame({}, input, 1).floor_num_keyframes, kNumFrames / 2 - 1);
}

// Without a floor to be seen, and across the axis the camera turns about: over the whole turn the
// samples' own mean is zero.
TEST(MapFrame, TheAccelerometerTurnsTheMapUpright) {
  MapFrameInput input = MakeInput(Rigid3());
  const Eigen::Vector3d up(1, 0, 0);
  for (std::size_t i = 0; i < input.keyframes.size(); ++i) {
    const double angle_rad =
        2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(input.keyframes.size());
    StampedPose& keyframe = input.keyframes[i];
    keyframe.pose.rotation = Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY());
    input.accelerometer.push_back(
        {keyframe.time_ns, keyframe.pose.rotation.conjugate() * (9.8 * up)});
  }
  input.load_depth = [](const FrameRecord& frame) -> DepthImage {
    throw DataError("{}: no depth in this test", frame.depth.path);
  };
  const MapFrame frame = RunMapFrame({}, input, 1);
  EXPECT_EQ(frame.gravity_source, "accelerometer");
  EXPECT_GT((frame.map_from_given.rotation * up).z(), 0.99);
}

TEST(MapFrame, GivenFrameIsKeptAndNoDepthIsRead) {
  MapFrameInput input = MakeInput(Rigid3());
  input.load_depth = nullptr;
  MapFrameOptions options;
  options.source = "given";
  const MapFrame frame = RunMapFrame(options, input, 1);
  EXPECT_EQ(frame.map_from_given.Matrix(), Rigid3().Matrix());
  EXPECT_NEAR(frame.camera_height_m, kHeight_m, 1e-9);
  EXPECT_TRUE(FloorWarnings(frame).empty());
  for (StampedPose& keyframe : input.keyframes) keyframe.pose.translation.z() -= 2;
  const auto warnings = FloorWarnings(RunMapFrame(options, input, 1));
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0], testing::HasSubstr("does not lie above z = 0"));
}

TEST(MapFrame, RefusesKeyframesOfOtherFrames) {
  MapFrameInput input = MakeInput(Rigid3());
  input.keyframes[1].time_ns += 1;
  NIGHTMAP_EXPECT_ERROR(DataError, RunMapFrame({}, input, 1), "time 3.000000001 is no frame");
}

}  // namespace nightmap::map_frame_test
