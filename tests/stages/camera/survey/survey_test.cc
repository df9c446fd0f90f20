// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "stages/camera/survey/depth_alignment.h"
#include "stages/camera/survey/frame_measures.h"
#include "stages/camera/survey/pair_measures.h"
#include "tests/stages/camera/survey/made_up_pictures.h"

namespace nightmap::survey_test {

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

}  // namespace nightmap::survey_test
