// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>

#include "stages/camera/survey/survey.h"
#include "stages/camera/survey/survey_output.h"
#include "tests/stages/camera/survey/made_up_pictures.h"
#include "tests/test_data.h"

namespace nightmap::survey_test {

SurveyInput InputOf(int num_frames) {
  static const Turning world;
  SurveyInput input;
  input.cameras.resize(1);
  input.cameras[0].color = {.width = kWidth, .height = kHeight};
  for (int i = 0; i < num_frames; ++i) {
    const std::string number = std::to_string(i);
    input.frames.push_back({i,
                            i * 100'000'000LL,
                            0,
                            0,
                            {number + ".png", number},
                            {number + "d.png", number + "d"},
                            {}});
  }
  input.load = [](const FrameRecord& frame) {
    if (frame.frame_idx == 13) throw DataError("13.png: cannot be read");
    const int place = frame.frame_idx % 40;
    return RgbdImages{ToColor(world.Color(place)), world.Depth(place), {}};
  };
  return input;
}

SurveyResult Survey(const SurveyInput& input,
                    int num_threads = 2,
                    const SurveyOptions& options = {}) {
  return RunSurvey(options, input, NoProgress(), num_threads);
}

TEST(Survey, LooksAtAllFramesOfAShortRecording) {
  const SurveyResult result = Survey(InputOf(40));
  EXPECT_EQ(result.num_sampled, 40U);
  EXPECT_EQ(result.frames.size(), 39U);
  ASSERT_EQ(result.skipped.size(), 1U);
  EXPECT_NE(result.skipped[0].find("13.png"), std::string::npos);
  int num_pairs = 0;
  for (const SurveyedFrame& frame : result.frames)
    num_pairs += frame.to_previous.has_previous ? 1 : 0;
  EXPECT_EQ(num_pairs, 37);  // none for the first frame, and for that after the lost one
  EXPECT_EQ(result.alignments.size(), 2U);
}

TEST(Survey, FramesOfOneVideoAreDifferentPictures) {
  SurveyInput input = InputOf(12);
  for (FrameRecord& frame : input.frames) frame.color.hash = frame.depth.hash = "of the video";
  for (const SurveyedFrame& frame : Survey(input).frames) {
    EXPECT_FALSE(frame.to_previous.same_color);
    EXPECT_FALSE(frame.to_previous.same_depth);
  }
}

TEST(Survey, FindsRepeatedDepthAndNoneInPicturesWithoutDepth) {
  SurveyInput input = InputOf(12);
  const RgbdLoader moving = input.load;
  for (const float depth_m : {2.0F, 0.0F}) {
    input.load = [&](const FrameRecord& frame) {
      RgbdImages images = moving(frame);
      std::ranges::fill(images.depth.pixels, depth_m);
      return images;
    };
    const SurveyResult result = Survey(input);
    for (std::size_t i = 1; i < result.frames.size(); ++i) {
      EXPECT_EQ(result.frames[i].to_previous.same_depth, depth_m > 0) << i;
    }
  }
}

TEST(Survey, TakesEvenlySpreadWindowsOfALongRecording) {
  SurveyOptions options;
  options.max_frames = 60;
  const SurveyResult result = Survey(InputOf(400), 2, options);
  EXPECT_EQ(result.num_sampled, 60U);
  EXPECT_EQ(result.frames.front().frame, 0U);
  EXPECT_GE(result.frames.back().frame, 260U);
}

TEST(Survey, IsTheSameAtAnyNumberOfThreads) {
  const SurveyInput input = InputOf(50);
  const SurveyResult one = Survey(input, 1), four = Survey(input, 4);
  EXPECT_EQ(SurveyToCsv(one, input.frames), SurveyToCsv(four, input.frames));
  EXPECT_EQ(Summarize(one, input.frames, input.cameras),
            Summarize(four, input.frames, input.cameras));
}

TEST(Survey, LeavesFieldsOfMissingDepthEmpty) {
  SurveyInput input = InputOf(12);
  for (FrameRecord& frame : input.frames) frame.depth = {};
  const RgbdLoader with_depth = input.load;
  input.load = [&](const FrameRecord& frame) {
    return RgbdImages{with_depth(frame).color, {}, {}};
  };
  const SurveyResult result = Survey(input);
  EXPECT_TRUE(result.alignments.empty());
  EXPECT_NE(SurveyToCsv(result, input.frames).find(",,,,,,,,\n"), std::string::npos);
}

// The camera of odd frames sees the robot; that of even ones does not.
TEST(Survey, FindsWhatStaysInThePicturesOfEachCamera) {
  SurveyInput input = InputOf(120);
  input.cameras.push_back(input.cameras.front());
  input.cameras.back().camera_id = "low";
  for (FrameRecord& frame : input.frames) frame.camera_idx = frame.frame_idx % 2;
  const GrayImage robot = Blocks(kWidth, kHeight, 9);
  input.load = [&](const FrameRecord& frame) {
    const auto seed = static_cast<std::uint64_t>(100 + frame.frame_idx);
    GrayImage gray = Blocks(kWidth, kHeight, seed);
    const auto first = frame.camera_idx == 0 ? gray.pixels.size() : gray.pixels.size() * 3 / 4;
    std::copy(robot.pixels.begin() + static_cast<std::ptrdiff_t>(first),
              robot.pixels.end(),
              gray.pixels.begin() + static_cast<std::ptrdiff_t>(first));
    return RgbdImages{ToColor(gray), {}, {}};
  };
  const SurveyResult result = Survey(input);
  const auto parts = Summarize(result, input.frames, input.cameras).at("fixed_parts");
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[0].at("share"), 0);
  EXPECT_FALSE(parts[0].contains("mask"));
  EXPECT_NEAR(parts[1].at("share").get<double>(), 0.25, 0.02);
  EXPECT_EQ(parts[1].at("camera_id"), "low");
  EXPECT_EQ(parts[1].at("num_views"), 60);
  EXPECT_EQ(parts[1].at("mask"), "mask_1.png");
}

}  // namespace nightmap::survey_test
