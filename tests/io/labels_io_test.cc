// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/labels_io.h"

#include "pipeline/base/input_error.h"
#include "pipeline/base/random.h"
#include "pipeline/io/frame_failure.h"
#include "pipeline/io/frame_labels.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap::labels_io_test {

constexpr int kVersion = 2;
const auto kRead = [](const std::filesystem::path& path) {
  const LabelsReader reader(path);
  for (const PackedLabels& frame : reader.Frames()) reader.Read(frame.time_ns);
};

LabelClasses SomeClasses() { return {{"background", "person", "potted plant"}, {0, 1, 0}}; }

Segmentation SomeSegmentation(int width, int height, std::uint64_t seed) {
  Random random(1, seed);
  Segmentation result{{width, height, 1, {}}, {width, height, 1, {}}};
  for (int i = 0; i < width * height; ++i) {
    result.labels.pixels.push_back(static_cast<std::uint8_t>(random.Index(3)));
    result.confidences.pixels.push_back(static_cast<std::uint8_t>(random.Index(256)));
  }
  return result;
}

LabelsShard SomeShard() {
  return {SomeClasses(),
          {PackLabels(4, 1'000'000'000'000, SomeSegmentation(20, 10, 0)),
           PackLabels(7, 1'000'100'000'000, SomeSegmentation(20, 10, 1)),
           PackLabels(8, 1'000'150'000'000, SomeSegmentation(7, 5, 2))}};
}

class LabelsIo : public InFolder {};

TEST_F(LabelsIo, ReadsBackEachFrameByItsTime) {
  const LabelsShard shard = SomeShard();
  WriteLabels(folder_ / "l.h5", shard, "config");
  const LabelsReader reader(folder_ / "l.h5");
  EXPECT_EQ(reader.Classes(), shard.classes);
  std::vector<int> frame_idx;
  for (const PackedLabels& frame : reader.Frames()) frame_idx.push_back(frame.frame_idx);
  EXPECT_THAT(frame_idx, testing::ElementsAre(4, 7, 8));
  for (std::uint64_t i = 0; i < 3; ++i) {
    const std::int64_t time_ns = shard.frames[i].time_ns;
    const Segmentation read = reader.Read(time_ns);
    const Segmentation expected = i == 2 ? SomeSegmentation(7, 5, 2) : SomeSegmentation(20, 10, i);
    EXPECT_EQ(read.labels.width, expected.labels.width);
    EXPECT_EQ(read.labels.height, expected.labels.height);
    EXPECT_EQ(read.labels.pixels, expected.labels.pixels);
    EXPECT_EQ(read.confidences.pixels, expected.confidences.pixels);
  }
}

TEST_F(LabelsIo, AFrameWithoutLabelsIsSaid) {
  WriteLabels(folder_ / "l.h5", SomeShard(), "");
  const LabelsReader reader(folder_ / "l.h5");
  NIGHTMAP_EXPECT_ERROR(DataError, reader.Read(5), "l.h5: field 'time_ns' does not hold 5");
}

// A fault of the labels is none of a picture, wherever they are read.
TEST(FrameLabels, WhatIsWrongWithAFileOfLabelsIsNoFailureOfAPicture) {
  const TemporaryFolder folder;
  LabelsShard shard = SomeShard();
  shard.frames[0].confidences.resize(shard.frames[0].confidences.size() / 2);
  WriteLabels(folder / "l.h5", shard, "");
  FrameRecord frame{7, shard.frames[1].time_ns, 0, 0, {"a.png", "h"}, {}, {}};
  frame.others[kLabelsChannel] = {"l.h5", "h"};
  const FrameLabels labels({folder / "l.h5"});
  Camera picture;
  picture.width = 20;
  picture.height = 10;
  EXPECT_EQ(labels.Of(frame, picture).labels.pixels, SomeSegmentation(20, 10, 1).labels.pixels);
  const auto read = [&] {
    std::ignore = FrameFailure("a.png", [&] { labels.Of(frame, picture); });
  };
  picture.width = 21;
  NIGHTMAP_EXPECT_ERROR(ArtifactError, read(), "l.h5: the labels of a.png are 20 x 10 pixels");
  picture.width = 20;
  frame.time_ns = shard.frames[0].time_ns;
  NIGHTMAP_EXPECT_ERROR(
      ArtifactError, read(), "l.h5: field 'confidences/1000000000000' is damaged");
  frame.time_ns = 3;
  NIGHTMAP_EXPECT_ERROR(ArtifactError, read(), "l.h5: field 'time_ns' does not hold 3");
  frame.others[kLabelsChannel].path = "m.h5";
  NIGHTMAP_EXPECT_ERROR(ArtifactError, read(), "a.png: its labels are in m.h5");
}

TEST_F(LabelsIo, AShardWithoutLabelledFramesIsReadBack) {
  WriteLabels(folder_ / "l.h5", {SomeClasses(), {}}, "");
  EXPECT_TRUE(LabelsReader(folder_ / "l.h5").Frames().empty());
}

TEST_F(LabelsIo, SizesOrdersAndLabelsThatDoNotFitAreNamed) {
  const auto expect = [&](const auto& change, const std::string& field) {
    LabelsShard shard = SomeShard();
    change(shard);
    WriteLabels(folder_ / "l.h5", shard, "");
    NIGHTMAP_EXPECT_ERROR(DataError, kRead(folder_ / "l.h5"), "l.h5: field '" + field + "'");
  };
  const std::string first = "labels/1000000000000";
  expect([](auto& shard) { shard.classes.names.pop_back(); }, "moving");
  expect([](auto& shard) { shard.classes.names[1] = ""; }, "classes");
  expect([](auto& shard) { shard.classes.names.resize(256, "x"); }, "classes");
  expect([](auto& shard) { shard.classes.moving[1] = 2; }, "moving");
  expect([](auto& shard) { shard.frames[1].frame_idx = 4; }, "frame_idx");
  expect([](auto& shard) { shard.frames[0].frame_idx = -1; }, "frame_idx");
  expect([](auto& shard) { std::swap(shard.frames[0].time_ns, shard.frames[1].time_ns); },
         "time_ns");
  expect([](auto& shard) { shard.frames[0].width = 0; }, "size_px");
  expect([](auto& shard) { shard.frames[0].height = 40'000; }, "size_px");
  expect([](auto& shard) { shard.frames[0].width = 21; }, first);
  expect([](auto& shard) { shard.frames[0].width = 19; }, first);
  expect([](auto& shard) { shard.frames[0].width = shard.frames[0].height = 30'000; }, first);
  expect([](auto& shard) { shard.frames[0].labels.pop_back(); }, first);
  expect([](auto& shard) { shard.frames[0].labels.clear(); }, first);
  expect([](auto& shard) { shard.frames[0].confidences.pop_back(); }, "confidences/1000000000000");
  expect([](auto& shard) { shard.classes = {{"a", "b"}, {0, 1}}; }, first);
}

// As another program might write it.
TEST_F(LabelsIo, MissingArraysAreNamed) {
  const Segmentation image = SomeSegmentation(4, 3, 0);
  const PackedLabels packed = PackLabels(0, 9, image);
  for (const std::string missing :
       {"", "classes", "moving", "frame_idx", "time_ns", "size_px", "labels/9", "confidences/9"}) {
    Hdf5Writer file(folder_ / "l.h5", "nightmap labels", kVersion, "", "");
    const auto write = [&]<typename T>(const std::string& name, const Array<T>& array) {
      if (name != missing) file.Write(name, array);
    };
    if (missing != "classes") file.WriteText("classes", "a\nb\nc");
    write("moving", Array<std::uint8_t>{3, 1, {0, 1, 0}});
    write("frame_idx", Array<std::int32_t>{1, 1, {0}});
    write("time_ns", Array<std::int64_t>{1, 1, {9}});
    write("size_px", Array<std::int32_t>{1, 2, {4, 3}});
    write("labels/9", Array<std::uint8_t>{packed.labels.size(), 1, packed.labels});
    write("confidences/9", Array<std::uint8_t>{packed.confidences.size(), 1, packed.confidences});
    file.Close();
    if (missing.empty()) {
      EXPECT_EQ(LabelsReader(folder_ / "l.h5").Read(9).labels.pixels, image.labels.pixels);
    } else {
      NIGHTMAP_EXPECT_ERROR(
          DataError, kRead(folder_ / "l.h5"), "l.h5: field '" + missing + "' is missing");
    }
  }
}

}  // namespace nightmap::labels_io_test
