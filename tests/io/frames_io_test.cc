// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frames_io.h"

#include "pipeline/base/error.h"
#include "tests/io/some_frames.h"
#include "tests/test_data.h"

namespace nightmap::frames_io_test {

class FramesCsv : public InFolder {};

TEST_F(FramesCsv, WhatIsWrittenIsRead) {
  const auto frames = SomeFrames(5, 20);
  const auto read = ReadFrames(folder_.Write("a.csv", FramesToCsv(frames)));
  ASSERT_EQ(read.size(), frames.size());
  EXPECT_EQ(FramesToCsv(read), FramesToCsv(frames));
  EXPECT_EQ(read[7].color.path, frames[7].color.path);
  EXPECT_EQ(read[7].time_ns, frames[7].time_ns);
  EXPECT_TRUE(ReadFrames(folder_.Write("empty.csv", FramesToCsv({}))).empty());
}

TEST_F(FramesCsv, AnotherChannelNeedsNoReaderAndChangesNoListWithoutIt) {
  auto frames = SomeFrames(0, 4);
  const std::string before = FramesToCsv(frames);
  frames[2].others["label"] = {"site/labels/2.png", "cd"};
  frames[3].others["thermal"] = {"site/heat, 3.tif", "ef"};
  const auto read = ReadFrames(folder_.Write("a.csv", FramesToCsv(frames)));
  EXPECT_TRUE(read[0].others.empty());
  EXPECT_EQ(read[2].others.at("label").path, "site/labels/2.png");
  EXPECT_EQ(read[2].others.count("thermal"), 0u);
  EXPECT_EQ(read[3].others.at("thermal").path, "site/heat, 3.tif");
  EXPECT_EQ(FramesToCsv(read), FramesToCsv(frames));
  frames[2].others.clear();
  frames[3].others.clear();
  EXPECT_EQ(FramesToCsv(frames), before);
}

TEST_F(FramesCsv, ChannelsOfTheHeaderAreChecked) {
  const std::string header = FramesToCsv({}).substr(0, FramesToCsv({}).size() - 1);
  for (const char* more : {",label_path",
                           ",label_hash,label_path",
                           ",label_path,other_hash",
                           ",_path,_hash",
                           ",color_path,color_hash",
                           ",label_path,label_hash,label_path,label_hash",
                           ",x,y"}) {
    NIGHTMAP_EXPECT_ERROR(
        DataError, ReadFrames(folder_.Write("h.csv", header + more + "\n")), "h.csv:1: column '");
  }
}

TEST_F(FramesCsv, ShardsMustFollowEachOther) {
  const auto a = folder_.Write("a.csv", FramesToCsv(SomeFrames(0, 4)));
  const auto b = folder_.Write("b.csv", FramesToCsv(SomeFrames(4, 3)));
  EXPECT_EQ(ReadFrames(std::vector{a, b}).size(), 7u);
  // Either may be the damaged one, so both are named.
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadFrames(std::vector{b, a}),
                        a.string() + " starts with frame 0, but " + b.string() +
                            ", the list before it, ends with frame 6");
  const auto empty = folder_.Write("empty.csv", FramesToCsv({}));
  NIGHTMAP_EXPECT_ERROR(DataError, ReadFrames(std::vector{a, empty}), "empty.csv: lists no frame");
}

TEST_F(FramesCsv, APictureIsOneFrame) {
  auto frames = SomeFrames(4, 3);
  frames[2].color.path = SomeFrames(0, 4)[1].color.path;
  const auto a = folder_.Write("a.csv", FramesToCsv(SomeFrames(0, 4)));
  const auto b = folder_.Write("b.csv", FramesToCsv(frames));
  NIGHTMAP_EXPECT_ERROR(DataError, ReadFrames(std::vector{a, b}), "b.csv: frame 6 has the picture");
}

TEST_F(FramesCsv, BadLinesAreNamed) {
  const std::string header = FramesToCsv({});
  const auto expect = [&](const std::string& line, const std::string& reason) {
    const auto path = folder_.Write("bad.csv", header + "0,1,0,0,a,ff,b,ee\n" + line + "\n");
    NIGHTMAP_EXPECT_ERROR(DataError, ReadFrames(path), "bad.csv:3: " + reason);
  };
  expect("1,2,0,0,a,ff,b", "7 fields, expected 8");
  expect("1,2,0,0,a,ff,b,ee,x", "9 fields");
  expect("1,2.5,0,0,a,ff,b,ee", "time_ns is '2.5', not an integer");
  expect("1,,0,0,a,ff,b,ee", "time_ns is '', not an integer");
  expect("1,2,-1,0,a,ff,b,ee", "camera_idx is -1, out of range");
  expect("1,2,99999999999,0,a,ff,b,ee", "camera_idx is 99999999999, out of range");
  expect("1,2,0,0,,,b,ee", "color_path is empty");
  expect("1,2,0,0,a,,b,ee", "color_hash is empty");
  expect("1,2,0,0,a,ff,,ee", "depth_path is empty");
  expect("1,2,0,0,a,ff,b,", "depth_hash is empty");
  expect("3,2,0,0,a,ff,b,ee", "frame_idx must count up by one");
  expect("1,2,0,0,\"a,ff,b,ee", "a quote");
  expect("", "1 fields");
  NIGHTMAP_EXPECT_ERROR(
      DataError, ReadFrames(folder_.Write("h.csv", "frame_idx\n0\n")), "h.csv:1: the header");
}

TEST_F(FramesCsv, TruncationIsRefusedAtEveryLengthWithinALine) {
  const std::string text = FramesToCsv(SomeFrames(0, 3));
  for (std::size_t length = 0; length < text.size(); ++length) {
    if (length > 0 && text[length - 1] == '\n') continue;
    ASSERT_THROW(ReadFrames(folder_.Write("cut.csv", text.substr(0, length))), DataError) << length;
  }
}

}  // namespace nightmap::frames_io_test
