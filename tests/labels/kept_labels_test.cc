// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/kept_labels.h"

#include "pipeline/base/files.h"
#include "tests/labels/fake_labels.h"
#include "tests/test_data.h"

namespace nightmap::kept_labels_test {

std::vector<FrameRecord> SomeFrames() {
  std::vector<FrameRecord> frames = FramesToLabel(4);
  for (FrameRecord& frame : frames) frame.color.hash = frame.color.path;
  return frames;
}
const std::vector<FrameRecord> kFrames = SomeFrames();

// Runs in one folder, one after the other.
class KeptLabelsTest : public testing::Test {
 protected:
  // Labels these frames, and returns the list that has the hashes of their labels and masks.
  std::string Run(const std::vector<std::size_t>& asked = {0, 1, 3}) {
    num_new_ = 0;
    const auto label = [&](const FrameRecord& frame, const RgbdImages& images) {
      ++num_new_;
      FrameRecord shown = frame;  // a picture shows the same at any time
      shown.frame_idx = std::stoi(frame.color.path);
      return LabelsOf(shown, images);
    };
    LabelledFrames labelled(
        model_, label, frames_, KeptLabels(Labels()), {source_, source_ + " 1"});
    for (const std::size_t i : asked) labelled.Label(i, {});
    WriteLabels(folder_ / "temporary", labelled.Labels(), "");  // as outputs are
    std::filesystem::rename(folder_ / "temporary", Labels());
    labelled.Keep();
    return FramesToCsv(labelled.FramesWithLabels("labels.h5", "masks.h5"));
  }
  std::filesystem::path Labels() const { return folder_ / "labels_0000.h5"; }
  std::filesystem::path Sources() const { return folder_ / "labels_0000.sources.csv"; }

  TemporaryFolder folder_;
  std::vector<FrameRecord> frames_ = kFrames;
  SegmentationModel model_ = kModel;
  std::string source_ = "network and program";
  int num_new_ = 0;
};

TEST_F(KeptLabelsTest, AnotherRunLabelsNothingAgainAndIsTheSame) {
  const std::string list = Run();
  EXPECT_EQ(num_new_, 3);
  const std::string labels = ReadBytes(Labels()), sources = ReadBytes(Sources());
  EXPECT_EQ(Run(), list);
  EXPECT_EQ(num_new_, 0);
  EXPECT_EQ(ReadBytes(Labels()), labels);
  EXPECT_EQ(ReadBytes(Sources()), sources);
  Run({0, 1, 2, 3});
  EXPECT_EQ(num_new_, 1);
}

TEST_F(KeptLabelsTest, FramesWithOtherNumbersAndTimesKeepTheirs) {
  Run();
  for (FrameRecord& frame : frames_) {
    frame.frame_idx += 10;
    frame.time_ns += 5;
  }
  Run();
  EXPECT_EQ(num_new_, 0);
  const LabelsReader reader(Labels());
  std::vector<int> frame_idx;
  for (const PackedLabels& frame : reader.Frames()) frame_idx.push_back(frame.frame_idx);
  EXPECT_EQ(frame_idx, (std::vector<int>{111, 112, 114}));
  EXPECT_EQ(reader.Read(frames_[3].time_ns).labels.pixels, LabelsOf(kFrames[3], {}).labels.pixels);
}

TEST_F(KeptLabelsTest, LabelsOfAnotherPictureCameraOrNetworkAreMadeAnew) {
  const auto num_new = [&](const auto& change) {
    Run();
    change();
    Run();
    return num_new_;
  };
  EXPECT_EQ(num_new([&] { frames_[1].color.hash = "another"; }), 1);
  EXPECT_EQ(num_new([&] { frames_[3].depth.hash = "another"; }), 1);
  EXPECT_EQ(num_new([&] { frames_[0].camera_idx = 1; }), 1);
  EXPECT_EQ(num_new([&] { frames_[0].others["label"] = {"label.png", "hash"}; }), 1);
  EXPECT_EQ(num_new([&] { frames_[0].color.path = "101.png#7"; }), 1);
  EXPECT_EQ(num_new([&] { source_ = "another"; }), 3);
}

TEST_F(KeptLabelsTest, FramesOfAVideoHaveTheirOwn) {
  for (FrameRecord& frame : frames_) frame.color.hash = "video";
  const std::string list = Run();
  EXPECT_EQ(Run(), list);
  EXPECT_EQ(num_new_, 0);
}

TEST_F(KeptLabelsTest, SourcesOfLabelsThatAKilledRunDidNotLeaveCostNoOthers) {
  const std::string list = Run();
  WriteFile(Sources(), ReadFile(Sources()) + "1000000000,0123456789abcdef,0123456789abcdef\n");
  EXPECT_EQ(Run(), list);
  EXPECT_EQ(num_new_, 0);
}

TEST_F(KeptLabelsTest, OptionsOfMasksAndNamesOfClassesLabelNothingAgain) {
  const std::string before = Run();
  model_.classes = {{"person", "cat"}, {1, 0}};
  model_.mask.margin_px = 2;
  const std::string after = Run();
  EXPECT_EQ(num_new_, 0);
  EXPECT_NE(after, before);
  std::filesystem::remove(Sources());
  EXPECT_EQ(Run(), after);
  EXPECT_EQ(num_new_, 3);
}

TEST_F(KeptLabelsTest, DamagedFilesCountAsEmpty) {
  const std::string list = Run();
  const std::string labels = ReadBytes(Labels()), sources = ReadBytes(Sources());
  const auto expect =
      [&](const std::string& damaged_labels, const std::string& damaged_sources, int num_new) {
        WriteFile(Labels(), damaged_labels);
        WriteFile(Sources(), damaged_sources);
        EXPECT_EQ(Run(), list);
        EXPECT_EQ(num_new_, num_new);
      };
  expect(labels.substr(0, labels.size() / 2), sources, 3);
  expect(labels, sources.substr(0, sources.size() / 2), 3);
  expect(labels, "time_ns,source\n", 3);
  std::string of_others = sources;  // the hash of the labels of the last frame
  char& last = of_others[of_others.size() - 2];
  last = last == '0' ? '1' : '0';
  expect(labels, of_others, 1);
}

TEST_F(KeptLabelsTest, LabelsThatTheSourcesDoNotMeanAreNotTaken) {
  const std::string list = Run();
  const std::string sources = ReadBytes(Sources());
  std::swap(frames_[0].color, frames_[1].color);
  Run();
  frames_ = kFrames;
  WriteFile(Sources(), sources);
  EXPECT_EQ(Run(), list);
  EXPECT_EQ(num_new_, 2);
}

}  // namespace nightmap::kept_labels_test
