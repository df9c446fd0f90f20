// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/segmentation_model.h"

#include "pipeline/base/error.h"
#include "tests/labels/tiny_network.h"

namespace nightmap::segmentation_model_test {

using Color = std::array<std::uint8_t, 3>;

SegmentationModel Parse(const std::string& text) {
  return ParseSegmentationModel(text, "m.toml", "models");
}

std::string Replaced(const std::string& old_text, const std::string& new_text) {
  std::string text = kTinyModel;
  const std::size_t at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return text.replace(at, old_text.size(), new_text);
}

TEST(SegmentationModel, IsReadAsWritten) {
  const SegmentationModel model = Parse(kTinyModel);
  EXPECT_EQ(model.source, "m.toml");
  EXPECT_EQ(model.network, "models/tiny.onnx");
  EXPECT_EQ(model.input_width_px, 40);
  EXPECT_EQ(model.input_height_px, 30);
  EXPECT_EQ(model.mean, (std::array<double, 3>{127.5, 127.5, 127.5}));
  EXPECT_EQ(model.scale, (std::array<double, 3>{127.5, 127.5, 127.5}));
  EXPECT_FALSE(model.is_bgr);
  EXPECT_EQ(model.classes.names, (std::vector<std::string>{"background", "person", "dog"}));
  EXPECT_EQ(model.classes.moving, (std::vector<std::uint8_t>{0, 1, 1}));
  EXPECT_TRUE(Parse(Replaced("\"rgb\"", "\"bgr\"")).is_bgr);
}

TEST(SegmentationModel, SaysHowSureAMaskIsAndHowWide) {
  const MovingMaskOptions by_default = Parse(kTinyModel).mask;
  EXPECT_EQ(by_default.min_confidence, 0.3);
  EXPECT_EQ(by_default.margin_px, 6);
  const std::string text = kTinyModel;
  const MovingMaskOptions given = Parse(text + "min_confidence = 0.5\nmargin_px = 0\n").mask;
  EXPECT_EQ(given.min_confidence, 0.5);
  EXPECT_EQ(given.margin_px, 0);
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        Parse(text + "min_confidence = 2.5\n"),
                        "m.toml:9: min_confidence = 2.5 is out of range; give 0 .. 1");
  NIGHTMAP_EXPECT_ERROR(UsageError, Parse(text + "margin_px = -1\n"), "m.toml:9: margin_px = -1");
  EXPECT_EQ(Parse(text).moving_gap_s, 0.05);
  EXPECT_EQ(Parse(text).still_gap_s, 0.3);
  EXPECT_EQ(Parse(text + "still_gap_s = 2.5\n").still_gap_s, 2.5);
}

TEST(SegmentationModel, MistakesAreNamedWithFileLineAndRemedy) {
  const auto expect =
      [](const std::string& old_text, const std::string& new_text, const std::string& message) {
        NIGHTMAP_EXPECT_ERROR(UsageError, Parse(Replaced(old_text, new_text)), message);
      };
  expect("input_width_px", "input_width", "m.toml:2: unknown key 'input_width'; known keys:");
  expect("= 40", "= \"40\"", "m.toml:2: 'input_width_px' must be an integer");
  expect("= 30", "= 0", "m.toml:3: input_height_px = 0 is out of range; give 8 .. 4096");
  expect("[127.5, 127.5, 127.5]", "127.5", "m.toml:4: 'mean' must be a list of numbers");
  expect("[127.5, 127.5, 127.5]", "[1, 2]", "m.toml:4: 'mean' has 2 numbers; give 3");
  expect("scale = [127.5,", "scale = [0,", "m.toml:5: scale = ");
  expect("\"rgb\"",
         "\"rbg\"",
         "m.toml:6: channel_order = \"rbg\" is out of range; give one of rgb, bgr");
  expect("\"dog\"]", "2]", "m.toml:7: 'classes' must be a list of strings");
  expect("\"dog\"]", "\"person\"]", "m.toml:7: 'classes' names \"person\" twice");
  expect("\"dog\"]", "\"\"]", "m.toml:7: 'classes' names \"\", which is empty");
  expect(
      "\"dog\"]", "\"d\\nog\"]", "m.toml:7: 'classes' names \"d\\x0aog\", which is empty or holds");
  expect(
      "\"dog\"]", "\"d\\u0007\"]", "m.toml:7: 'classes' names \"d\\x07\", which is empty or holds");
  expect(", \"person\", \"dog\"]", "]", "m.toml:7: 'classes' has 1 names; give 2 .. 255");
}

TEST(SegmentationModel, AMovingClassMustBeAClass) {
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        Parse(Replaced("moving = [\"person\"", "moving = [\"persons\"")),
                        "m.toml:8: 'moving' names \"persons\", which is no class; there are: "
                        "background, person, dog");
}

TEST(SegmentationModel, MissingKeysAndBrokenTomlAreNamed) {
  for (const std::string key : {"input_width_px", "input_height_px", "classes", "moving"}) {
    NIGHTMAP_EXPECT_ERROR(
        UsageError, Parse(Replaced(key + " =", "# =")), "m.toml: '" + key + "' is missing: add");
  }
  NIGHTMAP_EXPECT_ERROR(UsageError, Parse(Replaced("= 40", "40")), "m.toml:2: not valid TOML");
}

// The labels are pictures of the recording.
TEST(SegmentationModel, ANetworkMayBeMissing) {
  const TemporaryFolder folder;
  const auto path =
      folder.Write("classes.toml", "classes = [\"floor\", \"person\"]\nmoving = [\"person\"]\n");
  const SegmentationModel model = ReadSegmentationModel(path);
  EXPECT_FALSE(model.HasNetwork());
  EXPECT_EQ(model.classes.moving, (std::vector<std::uint8_t>{0, 1}));
  EXPECT_TRUE(Parse(kTinyModel).HasNetwork());
}

TEST(SegmentationModel, NothingNeedsToMove) {
  const SegmentationModel model = Parse("classes = [\"floor\", \"table\"]\nmoving = []\n");
  EXPECT_EQ(model.classes.moving, (std::vector<std::uint8_t>{0, 0}));
}

TEST(SegmentationModel, MissingFilesAreNamed) {
  const TemporaryFolder folder;
  NIGHTMAP_EXPECT_ERROR(
      UsageError, ReadSegmentationModel(folder / "no.toml"), "no.toml: no such model file");
  const auto path = folder.Write("tiny.toml", kTinyModel);
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        ReadSegmentationModel(path),
                        path.string() + ": found no network " + (folder / "tiny.onnx").string());
  EXPECT_EQ(ReadSegmentationModel(WriteTinyModel(folder)).network, folder / "tiny.onnx");
}

}  // namespace nightmap::segmentation_model_test
