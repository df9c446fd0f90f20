// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/labels.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/io/frame_reader.h"
#include "stages/labels/frame_labeller.h"
#include "stages/labels/report_labels.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

using Indices = std::vector<std::size_t>;

const SegmentationModel kNetwork{.network = "network.onnx"};

void AddSequence(int num_frames, double rate_hz, std::vector<FrameRecord>* frames) {
  const int sequence_idx = frames->empty() ? 0 : frames->back().sequence_idx + 1;
  const std::int64_t start_ns = frames->empty() ? 0 : frames->back().time_ns + 10'000'000'000;
  for (int i = 0; i < num_frames; ++i) {
    FrameRecord& frame = frames->emplace_back();
    frame.frame_idx = 100 + static_cast<int>(frames->size());
    frame.time_ns = start_ns + static_cast<std::int64_t>(1e9 * i / rate_hz);
    frame.sequence_idx = sequence_idx;
    frame.color = {std::to_string(frame.frame_idx) + ".png", "hash"};
  }
}

std::vector<FrameRecord> Sequence(int num_frames, double rate_hz) {
  std::vector<FrameRecord> frames;
  AddSequence(num_frames, rate_hz, &frames);
  return frames;
}

TEST(FramesToLabel, AreEveryNthAndTheLastOfEachSequence) {
  LabelsOptions options;
  options.every_n = 3;
  std::vector<FrameRecord> frames = Sequence(8, 30);
  EXPECT_EQ(FramesToLabel(options, kNetwork, frames), (Indices{0, 3, 6, 7}));
  AddSequence(4, 30, &frames);
  EXPECT_EQ(FramesToLabel(options, kNetwork, frames), (Indices{0, 3, 6, 7, 8, 11}));
  EXPECT_TRUE(FramesToLabel(options, kNetwork, {}).empty());
  options.every_n = 1'000'000;
  EXPECT_EQ(FramesToLabel(options, kNetwork, Sequence(1, 30)), (Indices{0}));
}

TEST(FramesToLabel, AreNinePerSecondByDefault) {
  const auto count = [](double rate_hz) {
    return FramesToLabel(LabelsOptions{}, kNetwork, Sequence(61, rate_hz)).size();
  };
  EXPECT_EQ(count(60), 10U);  // every seventh, and the last
  EXPECT_EQ(count(30), 21U);
  EXPECT_EQ(count(16), 31U);
  EXPECT_EQ(count(10), 61U);
  EXPECT_EQ(count(1), 61U);
}

TEST(FramesToLabel, GapsOfARecordingDoNotCount) {
  std::vector<FrameRecord> frames = Sequence(31, 30);
  for (std::size_t i = 10; i < frames.size(); ++i) frames[i].time_ns += 60'000'000'000;
  EXPECT_EQ(FramesToLabel(LabelsOptions{}, kNetwork, frames).size(), 11U);
}

// The top rows are people, one more per frame.
Segmentation LabelsOf(const FrameRecord& frame) {
  Segmentation result{{10, 20, 1, std::vector<std::uint8_t>(200)},
                      {10, 20, 1, std::vector<std::uint8_t>(200, 200)}};
  const auto num_people = static_cast<std::size_t>(10 * (frame.frame_idx - 100));
  std::fill_n(result.labels.pixels.begin(), num_people, 1);
  return result;
}

const LabelClasses kClasses{{"background", "person"}, {0, 1}, {{{0, 0, 0}}, {{192, 128, 128}}}};

LabelsResult LabelTwelve(const FrameLabeller& label, int num_threads) {
  LabelsOptions options;
  options.every_n = 2;
  Progress progress("labels");
  const auto frames = Sequence(12, 30);
  return RunLabels(options,
                   {.frames = frames,
                    .chosen = FramesToLabel(options, kNetwork, frames),
                    .cameras = {},
                    .classes = kClasses,
                    .label = label},
                   num_threads,
                   progress);
}

TEST(RunLabels, GivesTheSameAtAnyNumberOfThreads) {
  const LabelsResult one = LabelTwelve(LabelsOf, 1);
  const LabelsResult four = LabelTwelve(LabelsOf, 4);
  ASSERT_EQ(one.frames.size(), 7U);
  ASSERT_EQ(four.frames.size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(one.frames[i].frame_idx, i < 6 ? 101 + 2 * static_cast<int>(i) : 112);
    EXPECT_EQ(one.frames[i].frame_idx, four.frames[i].frame_idx);
    EXPECT_EQ(one.frames[i].labels, four.frames[i].labels);
    EXPECT_EQ(one.frames[i].confidences, four.frames[i].confidences);
    EXPECT_EQ(one.masks[i].runs, four.masks[i].runs);
  }
}

TEST(RunLabels, AFrameThatFailsIsLeftOutAndSaid) {
  const auto label = [](const FrameRecord& frame) {
    if (frame.frame_idx == 103) throw DataError("103.png: truncated");
    return LabelsOf(frame);
  };
  const LabelsResult result = LabelTwelve(label, 2);
  EXPECT_EQ(result.num_to_label, 7U);
  ASSERT_EQ(result.frames.size(), 6U);
  EXPECT_EQ(result.frames[1].frame_idx, 105);
  ASSERT_EQ(result.masks.size(), 6U);
  EXPECT_EQ(result.masks[1].time_ns, result.frames[1].time_ns);
  EXPECT_THAT(result.skipped, testing::ElementsAre(testing::HasSubstr("103.png: truncated")));
}

// A smooth pattern by chance; another from a shift of 500 px on.
ColorImage Waves(int shift_px) {
  Random random(shift_px < 500 ? 1 : 2);
  std::vector<Eigen::Vector3d> waves;
  for (int i = 0; i < 40; ++i) {
    waves.push_back({random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), random.Uniform(0, 6.3)});
  }
  ColorImage image{160, 120, 3, std::vector<std::uint8_t>(160UL * 120 * 3)};
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      double sum = 0;
      for (const auto& wave : waves) sum += std::sin(wave.dot(Eigen::Vector3d(x + shift_px, y, 1)));
      const auto gray = static_cast<std::uint8_t>(std::clamp(128 + 16 * sum, 0.0, 255.0));
      for (int k = 0; k < 3; ++k) image.At(x, y, k) = gray;
    }
  }
  return image;
}

// Labels the first and the last of 9 frames whose camera pans by 1 px, or jumps once, and those
// that it must between.
std::vector<int> LabelledOfPan(int jump_at, int failing, int num_threads) {
  LabelsInput input{
      .frames = Sequence(9, 30), .chosen = {0, 8}, .cameras = {}, .classes = kClasses};
  input.cameras.resize(1);
  input.cameras[0].color = Camera{160, 120, 150, 150, 79.5, 59.5};
  input.label = [&](const FrameRecord& frame) {
    if (frame.frame_idx == failing) throw DataError("truncated");
    return Segmentation{{160, 120, 1, std::vector<std::uint8_t>(160UL * 120)},
                        {160, 120, 1, std::vector<std::uint8_t>(160UL * 120, 200)}};
  };
  input.color = [&](const FrameRecord& frame) {
    const int i = frame.frame_idx - 101;
    return Waves(i + (i >= jump_at ? 500 : 0));
  };
  Progress progress("labels");
  std::vector<int> labelled;
  for (const auto& frame : RunLabels({}, input, num_threads, progress).frames) {
    labelled.push_back(frame.frame_idx);
  }
  return labelled;
}

TEST(RunLabels, LabelsBetweenWhereTheFeaturesAreLost) {
  using testing::ElementsAre;
  EXPECT_THAT(LabelledOfPan(9, 0, 1), ElementsAre(101, 109));
  EXPECT_THAT(LabelledOfPan(4, 0, 1), ElementsAre(101, 105, 109));
  EXPECT_THAT(LabelledOfPan(4, 0, 2), ElementsAre(101, 105, 109));
}

TEST(RunLabels, TheFrameAfterOneThatFailsIsLabelled) {
  using testing::ElementsAre;
  EXPECT_THAT(LabelledOfPan(9, 101, 1), ElementsAre(102, 109));
  EXPECT_THAT(LabelledOfPan(4, 105, 1), ElementsAre(101, 106, 109));
}

// Confidence 200 of 255 counts as sure; the margin of 6 rows below is masked, too.
TEST(RunLabels, MasksWhatMovesAndItsMargin) {
  const LabelsResult result = LabelTwelve(LabelsOf, 1);
  EXPECT_EQ(NumMasked(result.masks[1]), 90U);
  std::vector<FrameRecord> frames = Sequence(12, 30);
  NameMasks(result.masks, "shard_0007.h5", &frames);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool is_labelled = i % 2 == 0 || i == 11;
    ASSERT_EQ(frames[i].others.contains("mask"), is_labelled) << i;
    if (!is_labelled) continue;
    EXPECT_EQ(frames[i].others["mask"].path, "shard_0007.h5");
    EXPECT_EQ(frames[i].others["mask"].hash, HashOf(result.masks[i == 11 ? 6 : i / 2]));
  }
}

TEST(FramesToLabel, AreThoseWithLabelPicturesWithoutANetwork) {
  const SegmentationModel model{.source = "m.toml"};
  std::vector<FrameRecord> frames = Sequence(8, 30);
  NIGHTMAP_EXPECT_ERROR(UsageError, FramesToLabel({}, model, frames), "m.toml names no network");
  for (const std::size_t i : {2U, 3U, 7U}) frames[i].others["label"] = {"label.png", "hash"};
  EXPECT_EQ(FramesToLabel({}, model, frames), (Indices{2, 3, 7}));
}

// Label pictures of another program, and what is wrong with some.
TEST(MakeLabeller, ReadsLabelPicturesOfTheRecording) {
  const TemporaryFolder folder;
  GrayImage labels{6, 4, 1, std::vector<std::uint8_t>(24, 1)};
  WritePng(folder / "good.png", labels);
  labels.pixels[5] = 2;
  WritePng(folder / "class.png", labels);
  WritePng(folder / "size.png", GrayImage{4, 6, 1, std::vector<std::uint8_t>(24, 1)});
  RgbdCamera camera;
  camera.color = Camera{6, 4, 5, 5, 2.5, 1.5};
  const SegmentationModel model{.source = "m.toml", .classes = {"floor", "person"}};
  const FrameLabeller label = MakeLabeller(model, {camera}, folder.Path());
  FrameRecord frame;
  const auto with = [&](const std::string& name) {
    frame.others["label"] = {name, "hash"};
    return label(frame);
  };
  EXPECT_EQ(with("good.png").labels.pixels, std::vector<std::uint8_t>(24, 1));
  EXPECT_EQ(with("good.png").confidences.pixels, std::vector<std::uint8_t>(24, 255));
  NIGHTMAP_EXPECT_ERROR(
      DataError, with("class.png"), "class.png: label 2 is none of the 2 classes in m.toml");
  NIGHTMAP_EXPECT_ERROR(
      DataError, with("size.png"), "size.png: 4 x 6 labels for a picture of 6 x 4");
  NIGHTMAP_EXPECT_ERROR(DataError, with("none.png"), "none.png");
}

TEST(ReportLabels, HasSharesOfClassesAndOfWhatMoves) {
  nlohmann::json report;
  ReportLabels(LabelTwelve(LabelsOf, 1), kClasses, 12, &report);
  EXPECT_EQ(report["num_frames"], 12);
  EXPECT_EQ(report["num_labelled_frames"], 7);
  EXPECT_EQ(report["num_frames_mostly_moving"], 2);  // 11 and 12 of 20 rows
  EXPECT_NEAR(report["mean_class_shares"]["person"], (1 + 3 + 5 + 7 + 9 + 11 + 12) / 140.0, 1e-12);
  EXPECT_EQ(report["labelled_frame_idx"][6], 112);
  EXPECT_NEAR(report["moving_shares"][6], 0.6, 1e-12);
}

}  // namespace
}  // namespace nightmap
