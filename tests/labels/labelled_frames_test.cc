// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/labelled_frames.h"

#include <set>

#include "pipeline/base/error.h"
#include "pipeline/io/frame_reader.h"
#include "tests/labels/fake_labels.h"
#include "tests/test_data.h"

namespace nightmap::labelled_frames_test {

const std::vector<FrameRecord> kFrames = FramesToLabel(12);

TEST(LabelledFrames, AreThoseThatWereAskedForInOrder) {
  LabelledFrames labelled(kModel, LabelsOf, kFrames);
  EXPECT_TRUE(labelled.Labels().frames.empty());
  for (const std::size_t i : {7U, 2U, 4U}) labelled.Label(i, {});
  const LabelsShard labels = labelled.Labels();
  const std::vector<PackedMask> masks = labelled.Masks();
  EXPECT_EQ(labels.classes, kModel.classes);
  ASSERT_EQ(labels.frames.size(), 3U);
  ASSERT_EQ(masks.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    const FrameRecord& frame = kFrames[std::vector<std::size_t>{2, 4, 7}[i]];
    EXPECT_EQ(labels.frames[i].frame_idx, frame.frame_idx);
    EXPECT_EQ(labels.frames[i].time_ns, frame.time_ns);
    EXPECT_EQ(masks[i].time_ns, frame.time_ns);
  }
}

// Confidence 200 of 255 counts as sure; the margin of 6 rows below is masked, too.
TEST(LabelledFrames, MaskWhatMovesAndItsMargin) {
  LabelledFrames labelled(kModel, LabelsOf, kFrames);
  const GrayImage moving = labelled.Label(2, {});
  EXPECT_EQ(std::ranges::count(moving.pixels, 255), 90);
  EXPECT_EQ(UnpackMask(labelled.Masks()[0]).pixels, moving.pixels);
}

TEST(LabelledFrames, TheListNamesTheirMasks) {
  LabelledFrames labelled(kModel, LabelsOf, kFrames);
  for (const std::size_t i : {0U, 11U}) labelled.Label(i, {});
  const auto frames = labelled.FramesWithLabels("labels_0007.h5", "masks_0007.h5");
  ASSERT_EQ(frames.size(), kFrames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].frame_idx, kFrames[i].frame_idx);
    ASSERT_EQ(frames[i].others.contains(kMaskChannel), i == 0 || i == 11) << i;
  }
  const auto& mask = frames[11].others.at(kMaskChannel);
  EXPECT_EQ(mask.path, "masks_0007.h5");
  EXPECT_EQ(mask.hash, HashOf(labelled.Masks()[1]));
}

// The list stands for the files of labels and masks of the ports "by hash" of
// configs/*/pipeline.toml.
TEST(LabelledFrames, TheListTellsOfAnyChangeThatReadersWouldSee) {
  const auto list = [](const SegmentationModel& model, const auto& change) {
    const auto label = [&](const FrameRecord& frame, const RgbdImages& images) {
      Segmentation labels = LabelsOf(frame, images);
      change(&labels);
      return labels;
    };
    LabelledFrames labelled(model, label, kFrames);
    labelled.Label(3, {});
    return FramesToCsv(labelled.FramesWithLabels("labels.h5", "masks.h5"));
  };
  const auto nothing = [](Segmentation*) {};
  const auto of_classes = [&](const LabelClasses& classes) {
    SegmentationModel model = kModel;
    model.classes = classes;
    return list(model, nothing);
  };
  const auto labelled = [&](const auto& change) { return list(kModel, change); };
  const std::vector<std::string> lists = {
      labelled(nothing),
      of_classes({{"background", "human"}, {0, 1}}),
      of_classes({{"person", "background"}, {0, 1}}),
      of_classes({{"background", "person", "cat"}, {0, 1, 0}}),
      of_classes({{"background", "person"}, {0, 0}}),  // of the mask
      labelled([](Segmentation* s) { s->labels.pixels.back() = 1; }),
      labelled([](Segmentation* s) { s->confidences.pixels.back() = 199; }),
      labelled([](Segmentation* s) {
        for (auto* size : {&s->labels.width, &s->confidences.width}) *size *= 2;
        for (auto* size : {&s->labels.height, &s->confidences.height}) *size /= 2;
      })};
  EXPECT_EQ(std::set(lists.begin(), lists.end()).size(), lists.size());
  EXPECT_EQ(lists[0], labelled(nothing));
}

TEST(LabelledFrames, WithoutANetworkOnlyThoseWithALabelPictureCanBe) {
  SegmentationModel model = kModel;
  model.network.clear();
  NIGHTMAP_EXPECT_ERROR(
      UsageError, LabelledFrames(model, LabelsOf, kFrames), "m.toml names no network");
  EXPECT_NO_THROW(LabelledFrames(model, LabelsOf, {}));
  std::vector<FrameRecord> frames = kFrames;
  frames[3].others[kLabelChannel] = {"label.png", "hash"};
  const LabelledFrames labelled(model, LabelsOf, frames);
  const LabelledFrames by_network(kModel, LabelsOf, frames);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(labelled.CanLabel(i), i == 3);
    EXPECT_TRUE(by_network.CanLabel(i));
    EXPECT_EQ(labelled.IsDue(i, 0), i == 3);
  }
}

// 30 frames per second.
TEST(LabelledFrames, AreDueSoonerWhereSomethingMoves) {
  const auto label = [](const FrameRecord& frame, const RgbdImages& images) {
    Segmentation labels = LabelsOf(frame, images);
    if (frame.frame_idx != 102) std::ranges::fill(labels.labels.pixels, std::uint8_t{0});
    return labels;
  };
  const std::vector<FrameRecord> frames = FramesToLabel(30);
  LabelledFrames labelled(kModel, label, frames);
  labelled.Label(0, {});
  labelled.Label(1, {});
  for (std::size_t i = 2; i < frames.size(); ++i) {
    EXPECT_EQ(labelled.IsDue(i, 0), i >= 10) << i;
    EXPECT_EQ(labelled.IsDue(i, 1), i >= 3) << i;
  }
}

TEST(LabelledFrames, AFrameThatFailsIsNotAmongThem) {
  const auto label = [](const FrameRecord& frame, const RgbdImages& images) {
    if (frame.frame_idx == 103) throw DataError("103.png: truncated");
    return LabelsOf(frame, images);
  };
  LabelledFrames labelled(kModel, label, kFrames);
  labelled.Label(1, {});
  NIGHTMAP_EXPECT_ERROR(DataError, labelled.Label(2, {}), "103.png: truncated");
  ASSERT_EQ(labelled.Labels().frames.size(), 1U);
  EXPECT_FALSE(labelled.FramesWithLabels("l.h5", "m.h5")[2].others.contains(kMaskChannel));
}

TEST(LabelledFrames, TheReportHasSharesOfClassesAndOfWhatMoves) {
  LabelledFrames labelled(kModel, LabelsOf, kFrames);
  for (const std::size_t i : {0U, 2U, 4U, 6U, 8U, 10U, 11U}) labelled.Label(i, {});
  const nlohmann::json report = labelled.Summarize();
  EXPECT_EQ(report["num_frames"], 12);
  EXPECT_EQ(report["num_labelled_frames"], 7);
  EXPECT_EQ(report["num_frames_mostly_moving"], 2);  // 11 and 12 of 20 rows
  EXPECT_NEAR(report["mean_class_shares"]["person"], (1 + 3 + 5 + 7 + 9 + 11 + 12) / 140.0, 1e-12);
  EXPECT_EQ(report["labelled_frame_idx"][6], 112);
  EXPECT_NEAR(report["moving_shares"][6], 0.6, 1e-12);
}

}  // namespace nightmap::labelled_frames_test
