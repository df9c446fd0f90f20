// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/frame_labeller.h"

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::frame_labeller_test {

// Label pictures of another program, and what is wrong with some.
TEST(MakeLabeller, ReadsLabelPicturesOfTheRecording) {
  const TemporaryFolder folder;
  GrayImage labels{6, 4, 1, std::vector<std::uint8_t>(24, 1)};
  WritePng(folder / "good.png", labels);
  labels.pixels[5] = 2;
  WritePng(folder / "class.png", labels);
  WritePng(folder / "size.png", GrayImage{4, 6, 1, std::vector<std::uint8_t>(24, 1)});
  const SegmentationModel model{.source = "m.toml", .classes = {{"floor", "person"}, {}}};
  RgbdCamera camera;
  camera.color = {6, 4, 5, 5, 2.5, 1.5};
  const FrameLabeller label = MakeLabeller(model, {camera}, folder.Path());
  const RgbdImages images{{6, 4, 3, std::vector<std::uint8_t>(72)}, {}};
  FrameRecord frame;
  const auto with = [&](const std::string& name) {
    frame.others["label"] = {name, "hash"};
    return label(frame, images);
  };
  EXPECT_EQ(with("good.png").labels.pixels, std::vector<std::uint8_t>(24, 1));
  EXPECT_EQ(with("good.png").confidences.pixels, std::vector<std::uint8_t>(24, 255));
  NIGHTMAP_EXPECT_ERROR(
      DataError, with("class.png"), "class.png: label 2 is none of the 2 classes in m.toml");
  NIGHTMAP_EXPECT_ERROR(
      DataError, with("size.png"), "size.png: 4 x 6 labels for a picture of 6 x 4");
  NIGHTMAP_EXPECT_ERROR(DataError, with("none.png"), "none.png");
  ReduceToWorkingSize(6e-6, &camera);
  const FrameLabeller reduced = MakeLabeller(model, {camera}, folder.Path());
  frame.others["label"] = {"good.png", "hash"};
  EXPECT_EQ(reduced(frame, images).labels.pixels, std::vector<std::uint8_t>(6, 1));
}

}  // namespace nightmap::frame_labeller_test
