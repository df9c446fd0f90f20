// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/frame_labeller.h"

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap {
namespace frame_labeller_test {

// Label pictures of another program, and what is wrong with some.
TEST(MakeLabeller, ReadsLabelPicturesOfTheRecording) {
  const TemporaryFolder folder;
  GrayImage labels{6, 4, 1, std::vector<std::uint8_t>(24, 1)};
  WritePng(folder / "good.png", labels);
  labels.pixels[5] = 2;
  WritePng(folder / "class.png", labels);
  WritePng(folder / "size.png", GrayImage{4, 6, 1, std::vector<std::uint8_t>(24, 1)});
  const SegmentationModel model{.source = "m.toml", .classes = {{"floor", "person"}, {}}};
  const FrameLabeller label = MakeLabeller(model, folder.Path());
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
}

}  // namespace frame_labeller_test
}  // namespace nightmap
