// SPDX-License-Identifier: Apache-2.0
#include "stages/features/features.h"

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

class FeaturesTest : public testing::Test {
 protected:
  FeaturesTest() {
    cameras_[0].color = Camera{160, 120, 130, 130, 79.5, 59.5};
    for (int i = 0; i < 6; ++i)
      frames_.push_back({i + 30, i, 0, 0, {std::to_string(i), "h"}, {"d", "h"}, {}});
  }
  // Noise of the frame's own, at 2 m; frame 32 cannot be read.
  static RgbdImages Load(const FrameRecord& frame) {
    if (frame.frame_idx == 32) throw DataError("{}: truncated", frame.color.path);
    RgbdImages images;
    images.color = {160, 120, 3, std::vector<std::uint8_t>(160 * 120 * 3)};
    images.depth = {160, 120, 1, std::vector<float>(160 * 120, 2.0F)};
    Random random(static_cast<std::uint64_t>(frame.frame_idx));
    for (int y = 0; y < 120; y += 4) {
      for (int x = 0; x < 160; x += 4) {
        const auto gray = static_cast<std::uint8_t>(random.Index(256));
        for (int k = 0; k < 48; ++k) images.color.At(x + k % 4, y + k / 4 % 4, k / 16) = gray;
      }
    }
    return images;
  }
  FeaturesResult Extract(int num_threads, const FeaturesOptions& options = {}) const {
    Progress progress("features", false);
    return RunFeatures(options, {frames_, cameras_, Load, {}}, num_threads, progress);
  }

  std::vector<RgbdCamera> cameras_{RgbdCamera{}};
  std::vector<FrameRecord> frames_;
};

TEST_F(FeaturesTest, ABrokenFrameIsReportedAndStaysInItsPlace) {
  const FeaturesResult result = Extract(2);
  EXPECT_EQ(result.skipped, std::vector<std::string>{"2: truncated"});
  ASSERT_EQ(result.shard.frames.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const FrameFeatures& frame = result.shard.frames[i];
    EXPECT_EQ(frame.frame_idx, static_cast<int>(i) + 30);
    EXPECT_EQ(frame.NumFeatures() == 0, i == 2);
    for (const float depth_m : frame.depths_m) EXPECT_FLOAT_EQ(depth_m, 2.0F);
  }
}

TEST_F(FeaturesTest, FramesWithoutDepthHaveTheSameFeatures) {
  const auto load = [](const FrameRecord& frame) {
    RgbdImages images = Load(frame);
    images.depth = {};
    return images;
  };
  Progress progress("features", false);
  const auto without = RunFeatures({}, {frames_, cameras_, load, {}}, 1, progress);
  const auto with = Extract(1);
  EXPECT_EQ(without.skipped, with.skipped);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(without.shard.frames[i].descriptors, with.shard.frames[i].descriptors);
    EXPECT_EQ(without.shard.frames[i].keypoints_px, with.shard.frames[i].keypoints_px);
    for (const float depth_m : without.shard.frames[i].depths_m) EXPECT_EQ(depth_m, 0.0F);
  }
}

TEST_F(FeaturesTest, IsTheSameAtAnyNumberOfThreads) {
  const FeaturesResult one = Extract(1), four = Extract(4);
  EXPECT_EQ(one.skipped, four.skipped);
  ASSERT_EQ(one.shard.frames.size(), four.shard.frames.size());
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    EXPECT_EQ(one.shard.frames[i].descriptors, four.shard.frames[i].descriptors);
    EXPECT_EQ(one.shard.frames[i].keypoints_px, four.shard.frames[i].keypoints_px);
    EXPECT_EQ(one.shard.frames[i].depths_m, four.shard.frames[i].depths_m);
  }
}

// A picture without pixels, which OpenCV refuses, and one that does not fit into memory.
TEST_F(FeaturesTest, AnExceptionIsOfItsFrameAloneAtAnyNumberOfThreads) {
  const auto load = [](const FrameRecord& frame) {
    RgbdImages images = Load(frame);
    if (frame.frame_idx == 31) images.color = {};
    if (frame.frame_idx == 34) images.depth.pixels.resize(std::size_t{1} << 62);
    return images;
  };
  FeaturesOptions options;
  options.segment_frames = 3;
  const auto run = [&](int num_threads) {
    Progress progress("features", false);
    return RunFeatures(options, {frames_, cameras_, load, {}}, num_threads, progress);
  };
  const FeaturesResult one = run(1), four = run(4);
  ASSERT_EQ(one.skipped.size(), 3U);
  EXPECT_THAT(one.skipped[0], testing::StartsWith("1: OpenCV: "));
  EXPECT_EQ(one.skipped[1], "2: truncated");
  EXPECT_THAT(one.skipped[2], testing::StartsWith("4: needs more than any memory"));
  EXPECT_EQ(one.skipped, four.skipped);
  ASSERT_EQ(one.shard.frames.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const FrameFeatures& frame = one.shard.frames[i];
    EXPECT_EQ(frame.frame_idx, static_cast<int>(i) + 30);
    EXPECT_EQ(frame.NumFeatures() == 0, i == 1 || i == 2 || i == 4) << i;
    EXPECT_EQ(frame.raw_keypoints_px, four.shard.frames[i].raw_keypoints_px);
    EXPECT_EQ(frame.descriptors, four.shard.frames[i].descriptors);
  }
}

// One picture that moves to the left by two pixels a frame.
RgbdImages LoadMoving(const FrameRecord& frame) {
  RgbdImages images;
  images.color = {160, 120, 3, std::vector<std::uint8_t>(160 * 120 * 3)};
  images.depth = {160, 120, 1, std::vector<float>(160 * 120, 2.0F)};
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      Random random(1,
                    static_cast<std::uint64_t>((x + 2 * frame.frame_idx) / 5),
                    static_cast<std::uint64_t>(y / 5));
      const auto gray = static_cast<std::uint8_t>(random.Index(256));
      for (int channel = 0; channel < 3; ++channel) images.color.At(x, y, channel) = gray;
    }
  }
  return images;
}

TEST_F(FeaturesTest, DescribesTheFirstOfASegmentAndTheLastAndTracksBetween) {
  FeaturesOptions options;
  options.segment_frames = 4;
  Progress progress("features", false);
  const auto run = [&](int num_threads) {
    return RunFeatures(options, {frames_, cameras_, LoadMoving, {}}, num_threads, progress)
        .shard.frames;
  };
  const auto frames = run(1), again = run(2);
  const std::vector<int> expected = {-1, 30, 30, 30, -1, -1};
  for (std::size_t i = 0; i < 6; ++i) {
    ASSERT_EQ(frames[i].reference_frame_idx, expected[i]) << i;
    EXPECT_EQ(frames[i].raw_keypoints_px, again[i].raw_keypoints_px);
    EXPECT_EQ(frames[i].descriptors.empty(), !frames[i].IsDescribed());
    for (std::size_t k = 0; k < frames[i].reference_features.size(); ++k) {
      const auto feature = static_cast<std::size_t>(frames[i].reference_features[k]);
      const Eigen::Vector2f moved =
          frames[0].raw_keypoints_px[feature] - frames[i].raw_keypoints_px[k];
      EXPECT_NEAR(moved.x(), 2.0 * static_cast<double>(i), 0.3);
      EXPECT_NEAR(moved.y(), 0, 0.3);
      EXPECT_FLOAT_EQ(frames[i].depths_m[k], 2.0F);
    }
  }
  options.tracking.max_gap_frames = 0;
  for (const FrameFeatures& frame : run(2)) EXPECT_TRUE(frame.IsDescribed());
}

// The first of the frames cannot be described, and one between cannot be tracked.
TEST_F(FeaturesTest, TheFollowersOfAFailedFrameAreNotLost) {
  const auto load = [](const FrameRecord& frame) {
    RgbdImages images = LoadMoving(frame);
    if (frame.frame_idx == 30 || frame.frame_idx == 33) images.color = {};
    return images;
  };
  Progress progress("features", false);
  const auto result = RunFeatures({}, {frames_, cameras_, load, {}}, 1, progress);
  EXPECT_EQ(result.skipped.size(), 2U);
  const std::vector<int> references = {-1, -1, 31, -1, 31, -1};
  for (std::size_t i = 0; i < 6; ++i) {
    const FrameFeatures& frame = result.shard.frames[i];
    EXPECT_EQ(frame.reference_frame_idx, references[i]) << i;
    EXPECT_EQ(frame.NumFeatures() == 0, i == 0 || i == 3) << i;
  }
}

TEST_F(FeaturesTest, AFrameOfAnotherCameraIsDescribed) {
  cameras_.push_back(cameras_[0]);
  for (std::size_t i = 3; i < 6; ++i) frames_[i].camera_idx = 1;
  Progress progress("features", false);
  const auto frames =
      RunFeatures({}, {frames_, cameras_, LoadMoving, {}}, 1, progress).shard.frames;
  EXPECT_FALSE(frames[2].IsDescribed());
  EXPECT_TRUE(frames[3].IsDescribed());
  EXPECT_EQ(frames[4].reference_frame_idx, 33);
}

// Every third frame has a mask of what moves.
TEST_F(FeaturesTest, OnlyFramesWithAMaskAreDescribed) {
  for (int i = 6; i < 14; ++i) {
    frames_.push_back({i + 30, i, 0, 0, {std::to_string(i), "h"}, {"d", "h"}, {}});
  }
  FeaturesInput input{frames_, cameras_, LoadMoving, {}};
  for (std::size_t i = 0; i < frames_.size(); ++i) input.may_describe.push_back(i % 3 == 1);
  FeaturesOptions options;
  options.segment_frames = 4;
  options.tracking.max_gap_frames = 2;
  Progress progress("features", false);
  const auto frames = RunFeatures(options, input, 2, progress).shard.frames;
  // 34 and 40 begin segments; 37 and 43 come after the longest gap.
  const std::vector<int> references = {-1, -1, 31, 31, -1, 34, 34, -1, 37, 37, -1, 40, 40, -1};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].reference_frame_idx, references[i]) << i;
    EXPECT_EQ(frames[i].NumFeatures() > 0, i > 0) << i;
    EXPECT_EQ(frames[i].descriptors.empty(), i % 3 != 1) << i;
  }
}

// A frame between that shows something else is not described without a mask.
TEST_F(FeaturesTest, AFrameWithoutAMaskKeepsTheFewThatAreFound) {
  const auto load = [](const FrameRecord& frame) {
    return frame.frame_idx == 32 ? Load({0, 0, 0, 0, {}, {}, {}}) : LoadMoving(frame);
  };
  FeaturesInput input{frames_, cameras_, load, {true, true, false, true, true, true}};
  Progress progress("features", false);
  const auto frames = RunFeatures({}, input, 1, progress).shard.frames;
  EXPECT_EQ(frames[2].reference_frame_idx, 30);
  EXPECT_LT(frames[2].NumFeatures(), frames[1].NumFeatures() / 2);
  EXPECT_TRUE(frames[3].IsDescribed());
}

TEST_F(FeaturesTest, WhatMovesHasNoFeaturesAndEndsTracks) {
  GrayImage left{160, 120, 1, {}};
  for (int i = 0; i < 160 * 120; ++i) left.pixels.push_back(i % 160 < 60 ? 255 : 0);
  const auto load = [&](const FrameRecord& frame) {
    RgbdImages images = LoadMoving(frame);
    if (frame.frame_idx >= 33) images.moving = left;
    return images;
  };
  Progress progress("features", false);
  const auto frames = RunFeatures({}, {frames_, cameras_, load, {}}, 1, progress).shard.frames;
  EXPECT_FALSE(frames[3].IsDescribed());
  EXPECT_TRUE(frames[5].IsDescribed());
  const auto in_mask = [](const FrameFeatures& frame) {
    return std::ranges::count_if(frame.raw_keypoints_px,
                                 [](const auto& pixel) { return pixel.x() < 59.5F; });
  };
  EXPECT_GT(in_mask(frames[2]), 20);
  EXPECT_EQ(in_mask(frames[3]), 0);
  EXPECT_EQ(in_mask(frames[4]), 0);
  EXPECT_EQ(in_mask(frames[5]), 0);
  EXPECT_GT(frames[3].NumFeatures(), 50);
}

TEST_F(FeaturesTest, TheShardSaysHowItWasMade) {
  const FeaturesResult result = Extract(1);
  ExtractionOptions extraction;
  extraction.num_features = 77;
  RegisterOptions(extraction).ParseToml(result.shard.extraction, "features");
  EXPECT_EQ(extraction.num_features, FeaturesOptions{}.extraction.num_features);
  FeaturesOptions options;
  options.extraction.detector = "orb";
  const FeaturesShard orb = Extract(1, options).shard;
  EXPECT_EQ(orb.kind, DescriptorKind::kOrb);
  EXPECT_EQ(orb.descriptor_size, 32);
  EXPECT_THAT(orb.extraction, testing::HasSubstr("detector = \"orb\""));
}

}  // namespace
}  // namespace nightmap
