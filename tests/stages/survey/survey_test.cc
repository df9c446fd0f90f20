// SPDX-License-Identifier: Apache-2.0
#include "stages/survey/survey.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "stages/survey/survey_output.h"

namespace nightmap {
namespace survey_test {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// Bright and dark squares of random size: sharp edges in every place, at several angles.
GrayImage Blocks(int width, int height, std::uint64_t seed) {
  Random random(seed, 0);
  GrayImage picture{
      width, height, 1, std::vector<std::uint8_t>(static_cast<std::size_t>(width * height), 100)};
  cv::Mat view(height, width, CV_8UC1, picture.pixels.data());
  for (int i = 0; i < 120; ++i) {
    const cv::Point2f center(static_cast<float>(random.Uniform(0, width)),
                             static_cast<float>(random.Uniform(0, height)));
    const cv::RotatedRect block(
        center,
        {static_cast<float>(random.Uniform(10, 60)), static_cast<float>(random.Uniform(10, 60))},
        static_cast<float>(random.Uniform(0, 180)));
    cv::Point2f corners[4];
    block.points(corners);
    std::vector<cv::Point> polygon(corners, corners + 4);
    cv::fillConvexPoly(view, polygon, cv::Scalar(random.Uniform(20, 235)), cv::LINE_AA);
  }
  return picture;
}

GrayImage Edited(GrayImage picture, const std::function<void(const cv::Mat&, cv::Mat&)>& edit) {
  cv::Mat view(picture.height, picture.width, CV_8UC1, picture.pixels.data());
  edit(view.clone(), view);
  return picture;
}

GrayImage Blurred(const GrayImage& picture, double sigma_px) {
  return Edited(picture, [&](const cv::Mat& from, cv::Mat& to) {
    cv::GaussianBlur(from, to, {0, 0}, sigma_px);
  });
}

// The picture as the camera sees it after a turn: its contents move to the left.
GrayImage Moved(const GrayImage& picture, int shift_px) {
  GrayImage moved = picture;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      moved.At(x, y) = picture.At(std::min(x + shift_px, picture.width - 1), y);
    }
  }
  return moved;
}

TEST(BlurOf, FindsTheSigmaOfGaussianBlur) {
  const GrayImage sharp = Blocks(640, 480, 1);
  EXPECT_LT(BlurOf(sharp), 1.2);
  for (const double sigma_px : {2.0, 3.0, 4.0}) {
    EXPECT_NEAR(BlurOf(Blurred(sharp, sigma_px)), sigma_px, 0.25 * sigma_px) << sigma_px;
  }
}

TEST(BlurOf, NoticesBlurAlongOneDirection) {
  const GrayImage moving = Edited(Blocks(640, 480, 1), [](const cv::Mat& from, cv::Mat& to) {
    cv::blur(from, to, {15, 1});
  });
  EXPECT_GT(BlurOf(moving), 3);
}

TEST(BlurOf, APictureWithoutEdgesHasNone) {
  EXPECT_EQ(BlurOf({64, 48, 1, std::vector<std::uint8_t>(64 * 48, 90)}), 0);
}

TEST(MeasureFrame, FindsExposureTextureAndDepth) {
  GrayImage gray = Blocks(kWidth, kHeight, 2);
  std::fill_n(gray.pixels.begin(), gray.pixels.size() / 4, std::uint8_t{255});
  DepthImage depth{kWidth, kHeight, 1, std::vector<float>(gray.pixels.size(), 2.0F)};
  std::fill_n(depth.pixels.begin(), depth.pixels.size() / 2, 0.0F);
  const FrameMeasures measures = MeasureFrame(gray, gray, depth);
  EXPECT_NEAR(measures.bright_share, 0.25, 0.01);
  EXPECT_GT(measures.textured_share, 0.5);
  EXPECT_NEAR(measures.measured_share, 0.5, 0.01);
  EXPECT_FLOAT_EQ(static_cast<float>(measures.depth_median_m), 2.0F);
  const GrayImage wall{kWidth, kHeight, 1, std::vector<std::uint8_t>(gray.pixels.size(), 200)};
  EXPECT_EQ(MeasureFrame(wall, wall, {}).textured_share, 0);
  EXPECT_EQ(MeasureFrame(wall, wall, {}).measured_share, 0);
}

TEST(MeasurePair, FindsMotionAndGain) {
  const GrayImage before = Blocks(kWidth, kHeight, 3);
  GrayImage after = Moved(before, 4);
  for (std::uint8_t& level : after.pixels) level = static_cast<std::uint8_t>(level * 0.5);
  const PairMeasures pair = MeasurePair(before, after);
  EXPECT_NEAR(pair.flow_px, 4, 0.1);
  EXPECT_GT(pair.tracked_share, 0.8);
  EXPECT_NEAR(pair.gain, 0.5, 0.03);
  EXPECT_FALSE(pair.same_color);
}

TEST(MeasurePair, AnotherPlaceIsNotFollowedAndHasNoGain) {
  const PairMeasures pair = MeasurePair(Blocks(kWidth, kHeight, 4), Blocks(kWidth, kHeight, 5));
  EXPECT_LT(pair.tracked_share, 0.15);
  EXPECT_EQ(pair.gain, 1);
}

TEST(MeasurePair, KnowsTheSamePixels) {
  const GrayImage picture = Blocks(kWidth, kHeight, 6);
  EXPECT_TRUE(MeasurePair(picture, picture).same_color);
}

// Boards before a far wall, seen by a camera that turns. Frame i of depth may be that of another.
struct Turning {
  GrayImage scene = Blocks(2 * kWidth, kHeight, 7);

  GrayImage Color(int frame) const { return Window(scene, frame); }
  DepthImage Depth(int frame, int shift_px = 0) const {
    const GrayImage gray = Window(scene, frame, shift_px);
    DepthImage depth{kWidth, kHeight, 1, {}};
    for (const std::uint8_t level : gray.pixels) depth.pixels.push_back(1.0F + 0.02F * level);
    return depth;
  }
  static GrayImage Window(const GrayImage& whole, int frame, int shift_px = 0) {
    GrayImage part{kWidth, kHeight, 1, {}};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x)
        part.pixels.push_back(whole.At(x + 5 * frame + 40 + shift_px, y));
    }
    return part;
  }
};

TEST(DepthAlignment, FindsTheFrameThatDepthBelongsTo) {
  const Turning world;
  std::vector<FrameEdges> frames;
  for (int i = 0; i < 20; ++i) frames.push_back(EdgesOf(world.Color(i), world.Depth(i + 2)));
  const auto by_offset = MeasureAlignment(frames).by_frame_offset;
  EXPECT_EQ(std::ranges::max_element(by_offset) - by_offset.begin(), kMaxFrameOffset + 2);
}

TEST(DepthAlignment, FindsTheShiftOfUnregisteredDepth) {
  const Turning world;
  for (const int shift_px : {0, 12}) {
    std::vector<FrameEdges> frames;
    for (int i = 0; i < 12; ++i)
      frames.push_back(EdgesOf(world.Color(i), world.Depth(i, shift_px)));
    const BestShift best = FindBestShift({MeasureAlignment(frames)});
    EXPECT_EQ(best.shift.x, shift_px);
    EXPECT_EQ(best.shift.y, 0);
  }
}

TEST(DepthAlignment, HasNoEdgesWithoutDepth) {
  const Turning world;
  EXPECT_EQ(MeasureAlignment({EdgesOf(world.Color(0), {}), EdgesOf(world.Color(1), {})}).num_edges,
            0);
  EXPECT_TRUE(FindBestShift({}).at_best.empty());
}

SurveyInput InputOf(const Turning& world, int num_frames) {
  SurveyInput input;
  RgbdCamera camera;
  camera.color.width = kWidth;
  camera.color.height = kHeight;
  input.cameras = {camera};
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
  input.load = [&world](const FrameRecord& frame) {
    if (frame.frame_idx == 13) throw DataError("13.png: cannot be read");
    const GrayImage gray = world.Color(frame.frame_idx % 40);
    RgbdImages images;
    images.color = {kWidth, kHeight, 3, {}};
    for (const std::uint8_t level : gray.pixels)
      images.color.pixels.insert(images.color.pixels.end(), 3, level);
    images.depth = world.Depth(frame.frame_idx % 40);
    return images;
  };
  return input;
}

TEST(Survey, LooksAtAllFramesOfAShortRecording) {
  const Turning world;
  const SurveyInput input = InputOf(world, 40);
  Progress progress("survey", false);
  const SurveyResult result = RunSurvey({}, input, 2, progress);
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

TEST(Survey, TakesEvenlySpreadWindowsOfALongRecording) {
  const Turning world;
  const SurveyInput input = InputOf(world, 400);
  SurveyOptions options;
  options.max_frames = 60;
  Progress progress("survey", false);
  const SurveyResult result = RunSurvey(options, input, 2, progress);
  EXPECT_EQ(result.num_sampled, 60U);
  EXPECT_EQ(result.frames.front().frame, 0U);
  EXPECT_GE(result.frames.back().frame, 260U);
}

TEST(Survey, IsTheSameAtAnyNumberOfThreads) {
  const Turning world;
  const SurveyInput input = InputOf(world, 50);
  Progress progress("survey", false);
  const SurveyResult one = RunSurvey({}, input, 1, progress),
                     four = RunSurvey({}, input, 4, progress);
  EXPECT_EQ(SurveyToCsv(one, input.frames), SurveyToCsv(four, input.frames));
  EXPECT_EQ(Summarize(one, input.frames), Summarize(four, input.frames));
}

TEST(Survey, LeavesFieldsOfMissingDepthEmpty) {
  const Turning world;
  SurveyInput input = InputOf(world, 12);
  for (FrameRecord& frame : input.frames) frame.depth = {};
  const RgbdLoader with_depth = input.load;
  input.load = [&](const FrameRecord& frame) {
    return RgbdImages{with_depth(frame).color, {}, {}};
  };
  Progress progress("survey", false);
  const SurveyResult result = RunSurvey({}, input, 2, progress);
  EXPECT_TRUE(result.alignments.empty());
  EXPECT_NE(SurveyToCsv(result, input.frames).find(",,,,,,,,\n"), std::string::npos);
}

}  // namespace survey_test
}  // namespace nightmap
