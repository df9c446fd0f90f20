// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/features/features.h"

#include <tuple>

#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::features_test {

// At 2 m.
RgbdImages Dark() {
  return {{160, 120, 3, std::vector<std::uint8_t>(160 * 120 * 3)},
          {160, 120, 1, std::vector<float>(160 * 120, 2.0F)},
          {}};
}

class FeaturesTest : public testing::Test {
 protected:
  FeaturesTest() {
    cameras_[0].color = Camera{160, 120, 130, 130, 79.5, 59.5};
    AddFrames(6);
  }

  void AddFrames(int end) {
    for (int i = static_cast<int>(frames_.size()); i < end; ++i) {
      frames_.push_back({i + 30, i, 0, 0, {std::to_string(i), "h"}, {"d", "h"}, {}});
    }
  }
  // Noise of the frame's own, at 2 m; frame 32 cannot be read.
  static RgbdImages Load(const FrameRecord& frame) {
    if (frame.frame_idx == 32) throw DataError("{}: truncated", frame.color.path);
    RgbdImages images = Dark();
    Random random(static_cast<std::uint64_t>(frame.frame_idx));
    for (int y = 0; y < 120; y += 4) {
      for (int x = 0; x < 160; x += 4) {
        const auto gray = static_cast<std::uint8_t>(random.Index(256));
        for (int k = 0; k < 48; ++k) images.color.At(x + k % 4, y + k / 4 % 4, k / 16) = gray;
      }
    }
    return images;
  }
  FeaturesResult Run(const RgbdLoader& load,
                     int num_threads = 1,
                     LabelledFrames* labelled = nullptr) const {
    return RunFeatures(options_, {frames_, cameras_, load, labelled}, NoProgress(), num_threads);
  }

  std::vector<RgbdCamera> cameras_{RgbdCamera{}};
  std::vector<FrameRecord> frames_;
  FeaturesOptions options_;
};

TEST_F(FeaturesTest, ABrokenFrameIsReportedAndStaysInItsPlace) {
  const FeaturesResult result = Run(Load, 2);
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
  const auto without = Run(load), with = Run(Load);
  EXPECT_EQ(without.skipped, with.skipped);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(without.shard.frames[i].descriptors, with.shard.frames[i].descriptors);
    EXPECT_EQ(without.shard.frames[i].keypoints_px, with.shard.frames[i].keypoints_px);
    for (const float depth_m : without.shard.frames[i].depths_m) EXPECT_EQ(depth_m, 0.0F);
  }
}

TEST_F(FeaturesTest, IsTheSameAtAnyNumberOfThreads) {
  const FeaturesResult one = Run(Load, 1), four = Run(Load, 4);
  EXPECT_EQ(one.skipped, four.skipped);
  EXPECT_EQ(one.shard.frames, four.shard.frames);
}

// A picture without pixels, which OpenCV refuses, and one that does not fit into memory.
TEST_F(FeaturesTest, AnExceptionIsOfItsFrameAloneAtAnyNumberOfThreads) {
  const auto load = [](const FrameRecord& frame) {
    RgbdImages images = Load(frame);
    if (frame.frame_idx == 31) images.color = {};
    if (frame.frame_idx == 34) images.depth.pixels.resize(std::size_t{1} << 62);
    return images;
  };
  options_.segment_frames = 3;
  const FeaturesResult one = Run(load, 1), four = Run(load, 4);
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
    EXPECT_EQ(frame, four.shard.frames[i]) << i;
  }
}

// One picture that moves to the left by two pixels a frame.
RgbdImages LoadMoving(const FrameRecord& frame) {
  RgbdImages images = Dark();
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
  options_.segment_frames = 4;
  const auto frames = Run(LoadMoving).shard.frames;
  EXPECT_EQ(Run(LoadMoving, 2).shard.frames, frames);
  const std::vector<int> expected = {-1, 30, 30, 30, -1, -1};
  for (std::size_t i = 0; i < 6; ++i) {
    ASSERT_EQ(frames[i].reference_frame_idx, expected[i]) << i;
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
  options_.tracking.max_gap_frames = 0;
  for (const auto& frame : Run(LoadMoving).shard.frames) EXPECT_TRUE(frame.IsDescribed());
}

// The first of the frames cannot be described, and one between cannot be tracked.
TEST_F(FeaturesTest, TheFollowersOfAFailedFrameAreNotLost) {
  const auto load = [](const FrameRecord& frame) {
    RgbdImages images = LoadMoving(frame);
    if (frame.frame_idx == 30 || frame.frame_idx == 33) images.color = {};
    return images;
  };
  const auto result = Run(load);
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
  const auto frames = Run(LoadMoving).shard.frames;
  EXPECT_FALSE(frames[2].IsDescribed());
  EXPECT_TRUE(frames[3].IsDescribed());
  EXPECT_EQ(frames[4].reference_frame_idx, 33);
}

// A model whose labels are pictures: the frames of `has_label` have one.
SegmentationModel WithPictures() {
  return {.source = "m.toml", .classes = {{"wall", "person"}, {0, 1}}};
}

// Frames are labelled after so many seconds even if they bring nothing new.
SegmentationModel WithNetwork(double still_gap_s) {
  SegmentationModel model = WithPictures();
  model.network = "network.onnx";
  model.still_gap_s = still_gap_s;
  return model;
}

std::int64_t NumOnPerson(const FrameFeatures& frame) {
  return std::ranges::count_if(frame.raw_keypoints_px,
                               [](const auto& pixel) { return pixel.x() < 59.5F; });
}

// A person is left of a column; in none of the pictures where that is 0.
FrameLabeller PersonLeftOf(int column) {
  return [=](const FrameRecord&, const RgbdImages& images) {
    Segmentation labels{{160, 120, 1, {}},
                        {160, 120, 1, std::vector<std::uint8_t>(160 * 120, 255)}};
    for (int i = 0; i < 160 * 120; ++i) labels.labels.pixels.push_back(i % 160 < column);
    EXPECT_EQ(images.color.pixels.size(), 160U * 120 * 3);
    EXPECT_TRUE(images.moving.pixels.empty());
    return labels;
  };
}

// Every third frame has a label picture.
TEST_F(FeaturesTest, OnlyFramesThatCanBeLabelledAreDescribed) {
  AddFrames(14);
  for (std::size_t i = 1; i < frames_.size(); i += 3) frames_[i].others[kLabelChannel] = {"l", "h"};
  LabelledFrames labelled(WithPictures(), PersonLeftOf(0), frames_);
  options_.segment_frames = 4;
  options_.tracking.max_gap_frames = 2;
  const auto frames = Run(LoadMoving, 2, &labelled).shard.frames;
  // 34 and 40 begin segments; 37 and 43 come after the longest gap.
  const std::vector<int> references = {-1, -1, 31, 31, -1, 34, 34, -1, 37, 37, -1, 40, 40, -1};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].reference_frame_idx, references[i]) << i;
    EXPECT_EQ(frames[i].NumFeatures() > 0, i > 0) << i;
    EXPECT_EQ(frames[i].descriptors.empty(), i % 3 != 1) << i;
  }
  EXPECT_EQ(labelled.Masks().size(), 5U);
}

// A frame between that shows something else is not described without a label picture.
TEST_F(FeaturesTest, AFrameThatCannotBeLabelledKeepsTheFewThatAreFound) {
  const auto load = [](const FrameRecord& frame) {
    return frame.frame_idx == 32 ? Load({0, 0, 0, 0, {}, {}, {}}) : LoadMoving(frame);
  };
  for (const std::size_t i : {0U, 1U, 3U, 4U, 5U}) frames_[i].others[kLabelChannel] = {"l", "h"};
  LabelledFrames labelled(WithPictures(), PersonLeftOf(0), frames_);
  const auto frames = Run(load, 1, &labelled).shard.frames;
  EXPECT_EQ(frames[2].reference_frame_idx, 30);
  EXPECT_LT(frames[2].NumFeatures(), frames[1].NumFeatures() / 2);
  EXPECT_TRUE(frames[3].IsDescribed());
}

// A frame whose loader masks parts of the robot is not labelled yet.
TEST_F(FeaturesTest, AFrameWithTheMaskOfItsCameraIsLabelled) {
  const auto load = [](const FrameRecord& frame) {
    RgbdImages images = LoadMoving(frame);
    const ColorImage& color = images.color;
    images.moving = {
        color.width, color.height, 1, std::vector<std::uint8_t>(color.pixels.size() / 3)};
    images.moving.pixels[0] = 255;
    return images;
  };
  const FrameLabeller nobody = [](const FrameRecord&, const RgbdImages&) {
    return Segmentation{{160, 120, 1, std::vector<std::uint8_t>(160 * 120)},
                        {160, 120, 1, std::vector<std::uint8_t>(160 * 120, 255)}};
  };
  const SegmentationModel model = WithNetwork(1);
  LabelledFrames plain(model, nobody, frames_), masked(model, nobody, frames_);
  std::ignore = Run(LoadMoving, 1, &plain);
  std::ignore = Run(load, 1, &masked);
  EXPECT_FALSE(plain.Masks().empty());
  EXPECT_EQ(masked.Masks().size(), plain.Masks().size());
}

// Where nobody is, labels change nothing: the same frames are described, and only they are
// labelled.
TEST_F(FeaturesTest, LabelsTheFramesThatAreDescribed) {
  const SegmentationModel model = WithNetwork(1);
  LabelledFrames labelled(model, PersonLeftOf(0), frames_);
  options_.segment_frames = 4;
  EXPECT_EQ(Run(LoadMoving, 2, &labelled).shard.frames, Run(LoadMoving, 2).shard.frames);
  std::vector<std::int32_t> idx;
  for (const PackedLabels& frame : labelled.Labels().frames) idx.push_back(frame.frame_idx);
  EXPECT_EQ(idx, (std::vector<std::int32_t>{30, 34, 35}));
}

// A person who comes in at frame 33, which is due and not described.
TEST_F(FeaturesTest, TracksThatRunIntoWhatMovesEnd) {
  const auto label = [](const FrameRecord& frame, const RgbdImages& images) {
    return PersonLeftOf(frame.frame_idx < 33 ? 0 : 60)(frame, images);
  };
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    frames_[i].time_ns = static_cast<std::int64_t>(i) * 100'000'000;
  }
  const SegmentationModel model = WithNetwork(0.25);
  LabelledFrames labelled(model, label, frames_);
  const auto frames = Run(LoadMoving, 1, &labelled).shard.frames;
  EXPECT_EQ(frames[3].reference_frame_idx, 30);
  EXPECT_GT(NumOnPerson(frames[2]), 20);
  for (const std::size_t i : {3U, 4U, 5U}) EXPECT_EQ(NumOnPerson(frames[i]), 0);
  EXPECT_GT(frames[3].NumFeatures(), 50);
}

TEST_F(FeaturesTest, WhatMovesHasNoFeatures) {
  const SegmentationModel model = WithNetwork(1);
  LabelledFrames labelled(model, PersonLeftOf(60), frames_);
  const auto masked = Run(LoadMoving, 1, &labelled).shard.frames;
  EXPECT_GT(NumOnPerson(Run(LoadMoving).shard.frames[0]), 20);
  EXPECT_EQ(NumOnPerson(masked[0]), 0);
  EXPECT_EQ(NumOnPerson(masked[5]), 0);
  EXPECT_GT(masked[0].NumFeatures(), 50);
  EXPECT_GT(masked[4].NumFeatures(), 50);
}

// Its labels cannot be read: the frame is left out, and the next is described in its place.
TEST_F(FeaturesTest, AFrameWhoseLabelsFailIsSkipped) {
  const auto label = [](const FrameRecord& frame, const RgbdImages& images) {
    if (frame.frame_idx == 30) throw DataError("30.png: label 9 is none of the 2 classes");
    return PersonLeftOf(0)(frame, images);
  };
  const SegmentationModel model = WithNetwork(1);
  LabelledFrames labelled(model, label, frames_);
  const auto result = Run(LoadMoving, 1, &labelled);
  EXPECT_EQ(result.skipped, std::vector<std::string>{"30.png: label 9 is none of the 2 classes"});
  EXPECT_EQ(result.shard.frames[0].NumFeatures(), 0);
  EXPECT_TRUE(result.shard.frames[1].IsDescribed());
  EXPECT_EQ(result.shard.frames[2].reference_frame_idx, 31);
}

}  // namespace nightmap::features_test
