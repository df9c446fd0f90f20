// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/labels.h"

#include "pipeline/base/error.h"
#include "stages/labels/report_labels.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

using Indices = std::vector<std::size_t>;

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
  EXPECT_EQ(FramesToLabel(options, frames), (Indices{0, 3, 6, 7}));
  AddSequence(4, 30, &frames);
  EXPECT_EQ(FramesToLabel(options, frames), (Indices{0, 3, 6, 7, 8, 11}));
  EXPECT_TRUE(FramesToLabel(options, {}).empty());
  options.every_n = 1'000'000;
  EXPECT_EQ(FramesToLabel(options, Sequence(1, 30)), (Indices{0}));
}

TEST(FramesToLabel, AreTenPerSecondByDefault) {
  const auto count = [](double rate_hz) {
    return FramesToLabel(LabelsOptions{}, Sequence(61, rate_hz)).size();
  };
  EXPECT_EQ(count(60), 11U);
  EXPECT_EQ(count(30), 21U);
  EXPECT_EQ(count(16), 31U);
  EXPECT_EQ(count(10), 61U);
  EXPECT_EQ(count(1), 61U);
}

TEST(FramesToLabel, GapsOfARecordingDoNotCount) {
  std::vector<FrameRecord> frames = Sequence(31, 30);
  for (std::size_t i = 10; i < frames.size(); ++i) frames[i].time_ns += 60'000'000'000;
  EXPECT_EQ(FramesToLabel(LabelsOptions{}, frames).size(), 11U);
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
  return RunLabels(options, Sequence(12, 30), kClasses, label, num_threads, progress);
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
  EXPECT_THAT(result.skipped, testing::ElementsAre(testing::HasSubstr("103.png: truncated")));
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
