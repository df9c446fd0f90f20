// SPDX-License-Identifier: Apache-2.0
// Recordings that lead elsewhere, never end, or cannot be named.
#include <sys/stat.h>

#include "pipeline/base/error.h"
#include "pipeline/io/image_io.h"
#include "pipeline/recording/inspect_frames.h"
#include "pipeline/recording/read_sequence.h"
#include "tests/test_data.h"

namespace nightmap::hostile_recordings_test {

namespace fs = std::filesystem;

constexpr int kWidth = 32;
constexpr int kHeight = 24;

// The recording data/site/rec in layout tum with three frames, and a picture outside of data.
class HostileRecordingTest : public testing::Test {
 protected:
  HostileRecordingTest() {
    site_.root = "site";
    site_.cameras.emplace_back().color = {
        .width = kWidth, .height = kHeight, .fx = 30, .fy = 30, .cx = 15.5, .cy = 11.5};
    config_.folder = "rec";
    config_.source = "site.toml:7";
    for (const char* name : {"rgb", "depth"}) fs::create_directories(Recording() / name);
    fs::create_directories(folder_ / "outside");
    const std::vector<std::uint8_t> color(kWidth * kHeight * 3, 100);
    const std::vector<std::uint16_t> depth(kWidth * kHeight, 1000);
    WritePng(folder_ / "outside/0.png", ColorImage{kWidth, kHeight, 3, color});
    std::string rgb_txt, depth_txt;
    for (int i = 0; i < 3; ++i) {
      WritePng(Recording() / fmt::format("rgb/{}.png", i), ColorImage{kWidth, kHeight, 3, color});
      WritePng(Recording() / fmt::format("depth/{}.png", i),
               RawDepthImage{kWidth, kHeight, 1, depth});
      rgb_txt += fmt::format("{}.1 rgb/{}.png\n", i, i);
      depth_txt += fmt::format("{}.1 depth/{}.png\n", i, i);
    }
    folder_.Write("data/site/rec/rgb.txt", rgb_txt);
    folder_.Write("data/site/rec/depth.txt", depth_txt);
  }

  fs::path Recording() const { return folder_ / "data/site/rec"; }
  void Link(const fs::path& target, const std::string& name) const {
    fs::remove_all(Recording() / name);
    fs::create_symlink(target, Recording() / name);
  }
  RawSequence Read(bool is_query = false) const {
    return ReadSequence(site_, config_, is_query, folder_ / "data");
  }
  std::vector<RawFrame> Inspect(bool is_query = false) const {
    std::vector<RawSequence> sequences = {Read(is_query)};
    Progress progress("test", false);
    HashCache files(folder_ / "hashes.csv", folder_ / "data");
    InspectFrames(site_.cameras, folder_ / "data", files, progress, 2, &sequences);
    return sequences[0].frames;
  }

  TemporaryFolder folder_;
  SiteConfig site_;
  SequenceConfig config_;
};

TEST_F(HostileRecordingTest, ALinkMayNotLeadOut) {
  const auto expect = [&](const std::string& name, const std::string& target) {
    const fs::path kept = folder_ / "kept";
    fs::rename(Recording() / name, kept);
    Link(folder_ / target, name);
    NIGHTMAP_EXPECT_ERROR(DataError,
                          Read(),
                          "data/site/rec/" + name + ": is a link to",
                          "add allow_outside = [\"" + name + "\"] to site.toml:7");
    config_.allow_outside = {name};
    EXPECT_EQ(Read().frames.size(), 3u);
    config_.allow_outside = {"other", name + "2"};
    EXPECT_THROW(Read(), DataError);
    config_.allow_outside.clear();
    fs::remove(Recording() / name);
    fs::rename(kept, Recording() / name);
    EXPECT_EQ(Read().frames.size(), 3u);
  };
  folder_.Write("outside/list.txt", "0.1 rgb/0.png\n1.1 rgb/1.png\n2.1 rgb/2.png\n");
  expect("rgb", "outside");
  expect("rgb/0.png", "outside/0.png");
  expect("depth/2.png", "outside/0.png");
  expect("rgb.txt", "outside/list.txt");
}

TEST_F(HostileRecordingTest, WhatIsBelowAnAllowedFolderMayLeadAnywhere) {
  Link(folder_ / "outside/0.png", "rgb/1.png");
  Link("/dev/null", "depth/1.png");
  config_.allow_outside = {"rgb/", "./depth"};
  EXPECT_EQ(Read().frames.size(), 3u);
  config_.allow_outside = {"."};
  EXPECT_EQ(Read().frames.size(), 3u);
}

TEST_F(HostileRecordingTest, FoldersOfTheSiteConfigAndLinksWithinTheDataAreFollowed) {
  fs::rename(Recording(), folder_ / "disk");  // the recording is kept elsewhere
  fs::create_symlink(folder_ / "disk", Recording());
  EXPECT_EQ(Read().frames.size(), 3u);
  fs::rename(folder_ / "data", folder_ / "real_data");  // and so is the data folder
  fs::create_symlink(folder_ / "real_data", folder_ / "data");
  EXPECT_EQ(Read().frames.size(), 3u);
  fs::rename(folder_ / "disk/rgb", folder_ / "data/site/shared");  // another recording's pictures
  Link(folder_ / "data/site/shared", "rgb");
  Link("../depth/1.png", "depth/0.png");
  for (const RawFrame& frame : Inspect()) {
    EXPECT_EQ(frame.problem + frame.depth_problem, "");
  }
}

TEST_F(HostileRecordingTest, SevenScenesFoldersAreHeldToTheSame) {
  config_.layout = "seven_scenes";
  for (const char* kind : {"color.png", "depth.png", "pose.txt"}) {
    fs::remove(Recording() / "frame-000000.color.png");
    folder_.Write("data/site/rec/frame-000000.color.png", "x");
    fs::remove(Recording() / "frame-000000.depth.png");
    const std::string name = std::string("frame-000000.") + kind;
    folder_.Write("outside/pose.txt", "1 0 0 4\n0 0 -1 5\n0 1 0 6\n0 0 0 1\n");
    Link(folder_ / "outside/pose.txt", name);
    NIGHTMAP_EXPECT_ERROR(DataError, Read(), name + ": is a link to");
  }
}

TEST_F(HostileRecordingTest, LinksToNothingAreTheProblemOfTheirFrame) {
  Link("nowhere.png", "rgb/0.png");
  Link("1.png", "rgb/1.png");  // of itself
  Link(folder_ / "gone.png", "depth/2.png");
  const auto frames = Inspect();
  EXPECT_EQ(frames[0].problem, "site/rec/rgb/0.png: no such image file");
  EXPECT_EQ(frames[1].problem, "site/rec/rgb/1.png: no such image file");
  EXPECT_EQ(frames[2].depth_problem, "site/rec/depth/2.png: no such image file");
}

TEST_F(HostileRecordingTest, APipeIsNotWaitedFor) {
  for (const char* name : {"rgb/0.png", "depth/1.png"}) {
    fs::remove(Recording() / name);
    ASSERT_EQ(mkfifo((Recording() / name).c_str(), 0600), 0);
  }
  const auto frames = Inspect();
  EXPECT_EQ(frames[0].problem, "site/rec/rgb/0.png: not a file");
  EXPECT_EQ(frames[1].depth_problem, "site/rec/depth/1.png: not a file");
  config_.layout = "video";
  config_.video = "rgb/0.png";
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "rgb/0.png: not a file");
}

TEST_F(HostileRecordingTest, NamesThatAreNotTextAreTheProblemOfTheirFrame) {
  fs::rename(Recording() / "rgb/0.png", Recording() / "rgb/\xff.png");
  fs::rename(Recording() / "depth/1.png", Recording() / "depth/\x01.png");
  fs::rename(Recording() / "rgb/2.png", Recording() / "rgb/a,\"b\".png");
  folder_.Write("data/site/rec/rgb.txt", "0.1 rgb/\xff.png\n1.1 rgb/1.png\n2.1 rgb/a,\"b\".png\n");
  folder_.Write("data/site/rec/depth.txt",
                "0.1 depth/0.png\n1.1 depth/\x01.png\n2.1 depth/2.png\n");
  const auto frames = Inspect();
  EXPECT_THAT(frames[0].problem,
              testing::StartsWith("site/rec/rgb/\\xff.png: the name is not UTF-8"));
  EXPECT_THAT(frames[1].depth_problem, testing::HasSubstr("depth/\\x01.png: the name"));
  EXPECT_EQ(frames[2].problem + frames[2].depth_problem, "");
  const std::vector<FrameRecord> records = {frames[2]};
  const auto read = ReadFrames(folder_.Write("frames.csv", FramesToCsv(records)));
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].color.path, "site/rec/rgb/a,\"b\".png");
}

TEST_F(HostileRecordingTest, DepthOfAQueryIsNoMatter) {
  folder_.Write("data/site/rec/depth.txt", "0.1 depth/a.png\n1.1 depth/b.png\n2.1 depth/2.png\n");
  const auto frames = Inspect(true);
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0].problem, "");
  EXPECT_EQ(frames[0].depth.path, "");
  EXPECT_EQ(frames[0].color.hash.size(), 16u);
  EXPECT_EQ(frames[2].depth.path, "site/rec/depth/2.png");
}

TEST_F(HostileRecordingTest, APictureIsOneFrameOfTheSite) {
  site_.sequences = {config_, config_};
  site_.sequences[1].time_offset_s = 100;
  site_.sequences[1].source = "site.toml:12";
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadSequences(site_, folder_ / "data"),
                        "site.toml:12: site/rec/rgb/0.png is a frame already, of site.toml:7");
  site_.sequences.pop_back();
  site_.queries = {config_};  // pictures of the map may be asked for
  EXPECT_EQ(ReadSequences(site_, folder_ / "data").size(), 1u);
  EXPECT_EQ(ReadQuerySequences(site_, folder_ / "data").size(), 1u);
}

TEST_F(HostileRecordingTest, TimesOutOfRangeAreRefused) {
  folder_.Write("data/site/rec/rgb.txt", "0.1 rgb/0.png\n4.5e9 rgb/1.png\n");
  EXPECT_NO_THROW(Read());
  config_.time_offset_s = 2e9;
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "site.toml:7: time 6500000000.000000 s is out of range");
  config_.time_offset_s = 0;
  config_.layout = "seven_scenes";
  folder_.Write("data/site/rec/frame-9000000000000000000.color.png", "x");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "frame 9000000000000000000 would be at 3e+17 s");
}

TEST_F(HostileRecordingTest, ReportsDoNotSayWhereTheDataFolderIs) {
  folder_.Write("data/site/rec/rgb/0.png", "");
  folder_.Write("data/site/rec/rgb/1.png", "hello");
  folder_.Write("data/site/rec/depth/2.png", "");
  for (const RawFrame& frame : Inspect()) {
    const std::string problem = frame.problem + frame.depth_problem;
    EXPECT_THAT(problem, testing::StartsWith("site/rec/"));
    EXPECT_THAT(problem, testing::Not(testing::HasSubstr(folder_.Path().string()))) << problem;
  }
}

}  // namespace nightmap::hostile_recordings_test
