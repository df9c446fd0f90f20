// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/labels/labels.h"

#include "pipeline/base/error.h"
#include "tests/labels/fake_labels.h"
#include "tests/test_data.h"

namespace nightmap::labels_test {

const std::vector<FrameRecord> kFrames = FramesToLabel(12);

LabelsResult Label(LabelledFrames* labelled, int num_threads = 2) {
  Progress progress("labels");
  return RunLabels(kFrames, NoPixels, labelled, progress, num_threads);
}

TEST(RunLabels, LabelsEveryFrameAlikeAtAnyNumberOfThreads) {
  LabelledFrames one(kModel, LabelsOf, kFrames), four(kModel, LabelsOf, kFrames);
  EXPECT_EQ(Label(&one, 1).num_to_label, 12U);
  Label(&four, 4);
  const LabelsShard a = one.Labels(), b = four.Labels();
  ASSERT_EQ(a.frames.size(), 12U);
  ASSERT_EQ(b.frames.size(), 12U);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(a.frames[i].frame_idx, 101 + static_cast<int>(i));
    EXPECT_EQ(a.frames[i].frame_idx, b.frames[i].frame_idx);
    EXPECT_EQ(a.frames[i].labels, b.frames[i].labels);
    EXPECT_EQ(a.frames[i].confidences, b.frames[i].confidences);
    EXPECT_EQ(one.Masks()[i].runs, four.Masks()[i].runs);
  }
}

TEST(RunLabels, AFrameThatFailsIsLeftOutAndSaid) {
  const auto label = [](const FrameRecord& frame, const RgbdImages& images) {
    if (frame.frame_idx == 103) throw DataError("103.png: truncated");
    return LabelsOf(frame, images);
  };
  LabelledFrames labelled(kModel, label, kFrames);
  const LabelsResult result = Label(&labelled);
  EXPECT_EQ(result.num_to_label, 12U);
  EXPECT_EQ(labelled.Masks().size(), 11U);
  EXPECT_THAT(result.skipped, testing::ElementsAre(testing::HasSubstr("103.png: truncated")));
}

TEST(RunLabels, LeavesOutFramesWithoutALabelPicture) {
  SegmentationModel model = kModel;
  model.network.clear();
  std::vector<FrameRecord> frames = kFrames;
  frames[5].others[kLabelChannel] = {"label.png", "hash"};
  LabelledFrames labelled(model, LabelsOf, frames);
  const LabelsResult result = Label(&labelled);
  EXPECT_EQ(result.num_to_label, 1U);
  EXPECT_TRUE(result.skipped.empty());
  ASSERT_EQ(labelled.Masks().size(), 1U);
  EXPECT_EQ(labelled.Masks()[0].time_ns, frames[5].time_ns);
}

}  // namespace nightmap::labels_test
