// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/read_sequence.h"

#include <opencv2/videoio.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/recording/inspect_frames.h"
#include "tests/test_data.h"

namespace nightmap::read_sequence_test {

constexpr int kWidth = 32;
constexpr int kHeight = 24;

// A data folder with the site "site" and one camera of 32 x 24.
class ReadSequenceTest : public testing::Test {
 protected:
  ReadSequenceTest() {
    site_.root = "site";
    RgbdCamera camera;
    camera.color = {.width = kWidth, .height = kHeight, .fx = 30, .fy = 30, .cx = 15.5, .cy = 11.5};
    site_.cameras = {camera};
    config_.source = "site.toml:7";
    std::filesystem::create_directories(folder_ / "site");
  }

  void WriteColor(const std::string& name, int width = kWidth) {
    std::filesystem::create_directories((folder_ / "site" / name).parent_path());
    const auto num_values = static_cast<std::size_t>(width * kHeight * 3);
    WritePng(folder_ / "site" / name,
             ColorImage{width, kHeight, 3, std::vector<std::uint8_t>(num_values, ++value_)});
  }
  void WriteDepth(const std::string& name, int width = kWidth) {
    std::filesystem::create_directories((folder_ / "site" / name).parent_path());
    const auto num_values = static_cast<std::size_t>(width * kHeight);
    WritePng(folder_ / "site" / name,
             RawDepthImage{width, kHeight, 1, std::vector<std::uint16_t>(num_values, ++value_)});
  }
  void WriteTum(int count) {
    std::string rgb = "# color\n", depth = "# depth\n";
    for (int i = 0; i < count; ++i) {
      const std::string n = std::to_string(i);
      WriteColor("rgb/" + n + ".png");
      WriteDepth("depth/" + n + ".png");
      rgb += fmt::format("{}.1 rgb/{}.png\n", i, n);
      depth += fmt::format("{}.11 depth/{}.png\n", i, n);
    }
    folder_.Write("site/rgb.txt", rgb);
    folder_.Write("site/depth.txt", depth);
  }

  RawSequence Read(bool is_query = false) const {
    return ReadSequence(site_, config_, is_query, folder_.Path());
  }
  RawSequence Inspect(int num_threads = 2) const {
    std::vector<RawSequence> sequences = {Read()};
    Progress progress("test", false);
    HashCache files(folder_ / "hashes.csv", folder_.Path());
    InspectFrames(site_.cameras, folder_.Path(), files, progress, num_threads, &sequences);
    return sequences[0];
  }

  TemporaryFolder folder_;
  SiteConfig site_;
  SequenceConfig config_;
  std::uint8_t value_ = 0;
};

TEST_F(ReadSequenceTest, TumFolder) {
  WriteTum(4);
  config_.time_offset_s = 10;
  config_.rig = "head";
  folder_.Write("site/truth.txt", "0.1 1 2 3 0 0 0 1\n");
  config_.ground_truth = "truth.txt";
  const auto sequence = Inspect();
  ASSERT_EQ(sequence.frames.size(), 4u);
  EXPECT_EQ(sequence.rig, "head");
  EXPECT_EQ(sequence.frames[2].time_ns, 12'100'000'000);
  EXPECT_EQ(sequence.frames[2].color.path, "site/rgb/2.png");
  EXPECT_EQ(sequence.frames[2].depth.path, "site/depth/2.png");
  EXPECT_EQ(sequence.frames[2].problem, "");
  EXPECT_EQ(sequence.frames[2].color.hash.size(), 16u);
  EXPECT_EQ(sequence.frames[2].depth.hash.size(), 16u);
  EXPECT_EQ(sequence.ground_truth.at(0).time_ns, 10'100'000'000);
}

TEST_F(ReadSequenceTest, HashesFollowTheBytesAndNotTheThreads) {
  WriteTum(6);
  const auto before = Inspect(1);
  WriteDepth("depth/3.png");
  const auto after = Inspect(2);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(before.frames[i].color.hash, after.frames[i].color.hash) << i;
    EXPECT_EQ(before.frames[i].depth.hash == after.frames[i].depth.hash, i != 3) << i;
  }
}

TEST_F(ReadSequenceTest, DamagedFramesCarryTheirProblem) {
  WriteTum(8);
  const auto png = ReadBytes(folder_ / "site/rgb/0.png");
  folder_.Write("site/rgb/0.png", png.substr(0, png.size() - 20));
  std::filesystem::remove(folder_ / "site/rgb/1.png");
  std::filesystem::remove(folder_ / "site/depth/2.png");
  WriteColor("rgb/3.png", kWidth + 1);
  WriteDepth("depth/4.png", kWidth / 2);
  WriteColor("depth/5.png");
  folder_.Write("site/rgb/6.png", "");
  const auto frames = Inspect().frames;
  EXPECT_EQ(frames[0].problem.rfind("site/rgb/0.png: truncated png file", 0), 0u);
  EXPECT_EQ(frames[1].problem, "site/rgb/1.png: no such image file");
  EXPECT_EQ(frames[2].depth_problem, "site/depth/2.png: no such image file");
  EXPECT_EQ(frames[3].problem,
            "site/rgb/3.png: 33 x 24 pixels, its camera has 32 x 24: pictures of another size need "
            "another camera");
  EXPECT_THAT(
      frames[4].depth_problem,
      testing::HasSubstr("site/depth/4.png: 16 x 24 pixels, its camera has 32 x 24: depth of "
                         "another size than color is not registered to it: give its "
                         "[[camera]] depth_registered = false with depth_width"));
  EXPECT_THAT(frames[5].depth_problem,
              testing::HasSubstr("site/depth/5.png: depth must be one channel"));
  EXPECT_THAT(frames[6].problem, testing::StartsWith("site/rgb/6.png"));
  EXPECT_EQ(frames[7].problem, "");
  for (const std::size_t i : {0, 1, 3, 6, 7}) EXPECT_EQ(frames[i].depth_problem, "") << i;
  for (const std::size_t i : {2, 4, 5}) EXPECT_EQ(frames[i].problem, "") << i;
}

TEST_F(ReadSequenceTest, DepthOfIntegersNeedsItsUnits) {
  WriteTum(1);
  EXPECT_EQ(Inspect().frames[0].depth_problem, "");
  site_.cameras[0].depth_units_per_m = 0;
  EXPECT_EQ(Inspect().frames[0].depth_problem,
            "site/depth/0.png: depth of integers needs depth_units_per_m in its [[camera]]");
}

TEST_F(ReadSequenceTest, DepthWithoutItsConfidenceIsAProblem) {
  WriteTum(6);
  config_.confidence_folder = "sure";
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "sure: no such folder: correct `confidence_folder`");
  std::filesystem::create_directories(folder_ / "site/sure");
  const auto write = [&](int i, int width, int height) {
    const auto num_pixels = static_cast<std::size_t>(width * height);
    WritePng(folder_ / "site/sure" / (std::to_string(i) + ".png"),
             GrayImage{width, height, 1, std::vector<std::uint8_t>(num_pixels, 2)});
  };
  write(0, kWidth, kHeight);
  write(1, kWidth / 4, kHeight / 4);
  write(2, kWidth / 4, kHeight / 2);
  write(3, 2 * kWidth, 2 * kHeight);
  WriteDepth("sure/4.png");
  const auto frames = Inspect().frames;
  for (const std::size_t i : {0, 1}) {
    EXPECT_EQ(frames[i].depth_problem, "");
    EXPECT_EQ(frames[i].depth.hash.size(), 16u);
    EXPECT_EQ(frames[i].others.at("confidence").path, fmt::format("site/sure/{}.png", i));
    EXPECT_EQ(frames[i].others.at("confidence").hash.size(), 16u);
  }
  const char* const problems[] = {
      "sure/2.png: 8 x 12 pixels, its depth has 32 x 24: a picture of confidence has the size",
      "sure/3.png: 64 x 48 pixels, its depth has 32 x 24",
      "sure/4.png: confidence must be one channel of 8 bits, this has 1 of 16",
      "sure/5.png: no such image file"};
  for (std::size_t i = 2; i < 6; ++i) {
    EXPECT_THAT(frames[i].depth_problem,
                testing::StartsWith(std::string("site/") + problems[i - 2]));
    EXPECT_TRUE(frames[i].depth.path.empty() && frames[i].others.empty());
    EXPECT_EQ(frames[i].problem, "");
  }
}

TEST_F(ReadSequenceTest, TumColorWithoutDepthIsAProblemUnlessItIsAQuery) {
  WriteTum(3);
  folder_.Write("site/depth.txt", "0.11 depth/0.png\n2.15 depth/2.png\n");
  const auto frames = Read().frames;
  EXPECT_EQ(frames[0].depth_problem, "");
  EXPECT_THAT(frames[1].depth_problem, testing::HasSubstr("no depth image within"));
  EXPECT_THAT(frames[2].depth_problem, testing::HasSubstr("max_association_gap_s = 0.02"));
  EXPECT_EQ(Read(true).frames[1].depth_problem, "");
  std::filesystem::remove(folder_ / "site/depth.txt");
  EXPECT_EQ(Read(true).frames[0].depth.path, "");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "depth.txt: missing");
}

TEST_F(ReadSequenceTest, ListsAreNotSortedByTimesThatNamesContradict) {
  WriteTum(2);
  const auto expect = [&](const std::string& lines, const std::string& why) {
    folder_.Write("site/rgb.txt", lines);
    NIGHTMAP_EXPECT_ERROR(DataError, Read(), "times must increase, and this is 0.1", why);
  };
  expect("0.2 rgb/2.png\n0.1 rgb/1.png\n", "after 0.200000: sort the lines by time");
  expect("0.9 rgb/9.png\n0.1 rgb/10.png\n",
         "the names of the pictures go on, so correct the times");
}

TEST_F(ReadSequenceTest, BadListsAreNamed) {
  WriteTum(2);
  const auto expect = [&](const std::string& line, const std::string& why) {
    folder_.Write("site/rgb.txt", "# c\n0.1 rgb/0.png\n" + line + "\n");
    NIGHTMAP_EXPECT_ERROR(DataError, Read(), "rgb.txt:3: ", why);
  };
  expect("1.1", "1 columns, expected 2");
  expect("1.1 rgb/1.png x", "3 columns");
  expect("nan rgb/1.png", "not a time");
  expect("0.1 rgb/1.png",
         "times must increase, and this is 0.100000 after 0.100000: remove repeated times");
  for (const char* path :
       {"/rgb/1.png", "../1.png", "rgb/../../../outside.jpg", "./../site/1.png"}) {
    expect(std::string("1.1 ") + path, "leads out of the recording's folder: give a path inside");
  }
  expect("1.1 rgb/0.png", "'site/rgb/0.png' is listed at 0.100000 s already");
  expect("1.1 rgb/../rgb/./0.png", "is listed at 0.100000 s already");
  expect("9e9 rgb/1.png", "time 9000000000.000000 s is out of range");
  expect("-9e9 rgb/1.png", "out of range");
  expect("1e308 rgb/1.png", "not a time");
}

// Pairs of each frame: time, color, depth.
std::string Pairs(const RawSequence& sequence) {
  std::string text;
  for (const RawFrame& frame : sequence.frames) {
    text += fmt::format("{} {} {}, ",
                        frame.time_ns / 1'000'000,
                        frame.color.path.substr(5),
                        frame.depth.path.empty() ? "-" : frame.depth.path.substr(5));
  }
  return text;
}

TEST_F(ReadSequenceTest, AssociationsArePairsInEitherOrder) {
  WriteTum(3);
  const auto write = [&](const std::string& lines) {
    folder_.Write("site/associations.txt", lines);
  };
  write("0.1 rgb/0.png 0.11 depth/2.png\n");
  EXPECT_EQ(Pairs(Read()),
            "100 rgb/0.png depth/0.png, 1100 rgb/1.png depth/1.png, "
            "2100 rgb/2.png depth/2.png, ");  // the lists are there
  std::filesystem::remove(folder_ / "site/depth.txt");
  EXPECT_EQ(Pairs(Read()), "100 rgb/0.png depth/2.png, ");
  EXPECT_EQ(Read(true).frames.size(), 3u);  // a query needs no depth
  std::filesystem::remove(folder_ / "site/rgb.txt");
  write(
      "# color depth\n0.1 rgb/0.png 0.11 depth/0.png\n0.3 rgb/1.png 0.28 depth/0.png\n"
      "0.4 rgb/2.png 0.43 depth/2.png\n");
  EXPECT_EQ(Pairs(Read()),
            "100 rgb/0.png depth/0.png, 300 rgb/1.png depth/0.png, 400 rgb/2.png -, ");
  EXPECT_THAT(Read().frames[2].depth_problem, testing::HasSubstr("max_association_gap_s = 0.02"));
  write("0 ./depth/0.png 0 ./rgb/0.png\n1 ./depth/1.png 1 ./rgb/1.png\n");
  EXPECT_EQ(Pairs(Read()), "0 rgb/0.png depth/0.png, 1000 rgb/1.png depth/1.png, ");
  write("0.1 a/0.png 0.1 b/0.png\n");  // color is first where paths say nothing
  EXPECT_EQ(Pairs(Read()), "100 a/0.png b/0.png, ");
  config_.depth = "none";
  EXPECT_EQ(Pairs(Read()), "100 a/0.png -, ");
}

TEST_F(ReadSequenceTest, BadAssociationsAreNamed) {
  std::filesystem::create_directories(folder_ / "site");
  const auto expect = [&](const std::string& line, const std::string& why) {
    folder_.Write("site/associations.txt",
                  "0.1 rgb/0.png 0.1 depth/0.png\n0.2 rgb/1.png 0.2 depth/1.png\n" + line + "\n");
    NIGHTMAP_EXPECT_ERROR(DataError, Read(), "associations.txt:3: ", why);
  };
  expect("1.1 rgb/2.png", "2 columns, expected 4 (time file time file)");
  expect("1.1 rgb/2.png 1.1 depth/2.png x", "5 columns");
  expect("1.1 depth/2.png 1.1 rgb/2.png", "most lines have color first, and this has not");
  expect("1.1 rgb/1.png 1.1 depth/2.png", "'site/rgb/1.png' is listed at 0.200000 s already");
  expect("0.2 rgb/2.png 0.3 depth/2.png", "times must increase");
  expect("1.1 rgb/2.png nan depth/2.png", "not a time");
  expect("1.1 rgb/2.png 1.1 ../depth/2.png", "leads out of the recording's folder");
  folder_.Write("site/associations.txt", "1305031102175 rgb/0.png 1305031102175 depth/0.png\n");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "associations.txt: its times cannot be in seconds");
}

TEST_F(ReadSequenceTest, TimesOfOtherUnitsAreTheSame) {
  WriteTum(1);
  config_.ground_truth = "truth.txt";
  const auto expect = [&](const std::string& unit, const std::string& time) {
    config_.time_unit = unit;
    folder_.Write("site/rgb.txt", time + " rgb/0.png\n");
    folder_.Write("site/depth.txt", time + " depth/0.png\n");
    folder_.Write("site/truth.txt", time + " 1 2 3 0 0 0 1\n");
    const RawSequence sequence = Read();
    EXPECT_EQ(sequence.frames.at(0).time_ns, 1305031102175304003) << unit;
    EXPECT_EQ(sequence.frames.at(0).depth.path, "site/depth/0.png") << unit;
    EXPECT_EQ(sequence.ground_truth.at(0).time_ns, 1305031102175304003) << unit;
  };
  expect("s", "1305031102.175304003");
  expect("ms", "1305031102175.304003");
  expect("us", "1305031102175304.003");
  expect("ns", "1305031102175304003");
}

TEST_F(ReadSequenceTest, TimesThatCannotBeSecondsNameTheirUnit) {
  WriteTum(1);
  const auto write = [&](const std::string& name, std::int64_t start, std::int64_t step) {
    std::string text;
    for (std::int64_t i = 0; i < 12; ++i) {
      text += fmt::format("{} {}\n",
                          start + i * step,
                          name == "truth.txt" ? "1 2 3 0 0 0 1" : fmt::format("rgb/{}.png", i));
    }
    folder_.Write("site/" + name, text);
  };
  const auto expect = [&](std::int64_t start, std::int64_t step, const std::string& unit) {
    write("rgb.txt", start, step);
    NIGHTMAP_EXPECT_ERROR(DataError,
                          Read(),
                          "site/rgb.txt: its times cannot be in seconds, they look like " + unit +
                              ": write time_unit = \"" + unit + "\" in the table at site.toml:7");
  };
  expect(0, 33, "ms");
  expect(0, 33'333, "us");
  expect(5'000'000, 33'333'333, "ns");
  expect(1305031102175, 33, "ms");
  expect(1305031102175304, 33'333, "us");
  expect(1305031102175304003, 33'333'333, "ns");
  expect(3'000'000'000'000'000, 33'333'333, "ns");                   // since the start, 35 days ago
  folder_.Write("site/rgb.txt", "1305031102175304003 rgb/0.png\n");  // too few lines for a step
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "time_unit = \"ns\"");
  write("rgb.txt", 0, 33);
  config_.time_unit = "s";
  config_.depth = "none";
  EXPECT_EQ(Read().frames.at(1).time_ns, 33'000'000'000);
  config_.time_unit = "";
  EXPECT_EQ(Read(true).frames.size(), 12u);  // queries may be of any times

  write("rgb.txt", 0, 1);
  write("truth.txt", 0, 1000);
  config_.ground_truth = "truth.txt";
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Read(),
                        "site/truth.txt: its times look like ms, and those of the pictures are in "
                        "seconds");
}

TEST_F(ReadSequenceTest, EmptyAndMissingFoldersAreNamedWithTheRemedy) {
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "rgb.txt: missing");
  folder_.Write("site/rgb.txt", "# nothing\n");
  folder_.Write("site/depth.txt", "# nothing\n");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "no pictures in layout \"tum\"");
  config_.layout = "seven_scenes";
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "no pictures in layout \"seven_scenes\"");
  config_.folder = "nowhere";
  NIGHTMAP_EXPECT_ERROR(
      DataError, Read(), "no such folder: correct `root` or `folder` in site.toml");
  config_.folder = "";
  config_.ground_truth = "truth.txt";
  config_.layout = "tum";
  WriteTum(1);
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "truth.txt");
}

TEST_F(ReadSequenceTest, SevenScenesFolder) {
  config_.layout = "seven_scenes";
  for (const char* n : {"000000", "000003", "000010"}) {
    WriteColor(std::string("frame-") + n + ".color.png");
    WriteDepth(std::string("frame-") + n + ".depth.png");
  }
  folder_.Write("site/frame-000000.pose.txt", "1 0 0 4\n0 0 -1 5\n0 1 0 6\n0 0 0 1\n");
  folder_.Write("site/frame-000003.pose.txt", "-1.#INF -inf inf nan\n0 0 -1 5\n0 1 0 6\n0 0 0 1\n");
  folder_.Write("site/notes.txt", "x");
  std::filesystem::remove(folder_ / "site/frame-000010.depth.png");
  const auto sequence = Read();
  ASSERT_EQ(sequence.frames.size(), 3u);
  EXPECT_EQ(sequence.frames[1].time_ns, 100'000'000);  // 3 / 30 s
  EXPECT_EQ(sequence.frames[1].depth.path, "site/frame-000003.depth.png");
  EXPECT_EQ(sequence.frames[2].depth_problem,
            "site/frame-000010.color.png: frame-000010.depth.png is missing");
  ASSERT_EQ(sequence.ground_truth.size(), 1u);  // tracking was lost in the second
  const Rigid3& pose = sequence.ground_truth[0].pose;
  EXPECT_EQ(pose.translation, Eigen::Vector3d(4, 5, 6));
  EXPECT_LT((pose * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(4, 4, 6)).norm(), 1e-12);
  config_.frame_rate_hz = 10;
  EXPECT_EQ(Read().frames[1].time_ns, 300'000'000);
}

TEST_F(ReadSequenceTest, SevenScenesPosesAreChecked) {
  config_.layout = "seven_scenes";
  WriteColor("frame-000000.color.png");
  const auto expect = [&](const std::string& pose, const std::string& why) {
    folder_.Write("site/frame-000000.pose.txt", pose);
    NIGHTMAP_EXPECT_ERROR(DataError, Read(), why);
  };
  expect("1 0 0\n", "3 numbers, expected a 4x4 matrix");
  expect("1 0 0 4\n0 x -1 5\n0 1 0 6\n0 0 0 1\n", "pose.txt:2: 'x'");
  expect("2 0 0 4\n0 0 -1 5\n0 1 0 6\n0 0 0 1\n", "not a rigid transform");
  expect("1 0 0 4\n0 0 1 5\n0 1 0 6\n0 0 0 1\n", "not a rigid transform");  // mirrored
  expect("1 0 0 1e308\n0 0 -1 5\n0 1 0 6\n0 0 0 1\n", "not a rigid transform");
}

TEST_F(ReadSequenceTest, VideoWithDepthFolder) {
  config_.layout = "video";
  config_.video = "clip.avi";
  config_.depth_folder = "depth";
  {
    cv::VideoWriter writer((folder_ / "site/clip.avi").string(),
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                           20.0,
                           cv::Size(kWidth, kHeight));
    ASSERT_TRUE(writer.isOpened());
    for (int i = 0; i < 3; ++i) writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(0)));
  }
  for (int i = 0; i < 3; ++i) WriteDepth(fmt::format("depth/{}.png", i));
  const auto frames = Inspect().frames;
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[2].color.path, "site/clip.avi#2");
  EXPECT_EQ(frames[2].depth.path, "site/depth/2.png");
  EXPECT_EQ(frames[2].time_ns, 100'000'000);
  EXPECT_EQ(frames[2].problem, "");
  EXPECT_EQ(frames[2].color.hash, frames[0].color.hash);
  EXPECT_TRUE(Read().left_out.empty());
  config_.video = "none.avi";
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "none.avi: no such video file");
}

class ReadVideoTest : public ReadSequenceTest {
 protected:
  static constexpr int kNumFrames = 6;
  static constexpr int kPeriod_ms = 40;

  ReadVideoTest() {
    config_.layout = "video";
    config_.video = "clip.mkv";
    config_.depth_folder = "depth";
    cv::VideoWriter writer(Clip().string(),
                           cv::CAP_FFMPEG,
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                           1000.0 / kPeriod_ms,
                           cv::Size(kWidth, kHeight));
    for (int i = 0; i < kNumFrames; ++i) {
      writer.write(cv::Mat(kHeight, kWidth, CV_8UC3, cv::Scalar::all(20 * i)));
      WriteDepth(fmt::format("depth/{}.png", i));
    }
  }
  std::filesystem::path Clip() const { return folder_ / "site/clip.mkv"; }

  // Moves frame `i` in time: Matroska has a time (ms) before each frame, which is a key frame.
  void Move(int i, int to_ms) {
    const auto header = [](int time_ms) {
      return std::string{
          '\x81', static_cast<char>(time_ms >> 8), static_cast<char>(time_ms), '\x80'};
    };
    std::string bytes = ReadBytes(Clip());
    const std::size_t at = bytes.find(header(i * kPeriod_ms) + "\xFF\xD8");
    ASSERT_NE(at, std::string::npos) << i;
    folder_.Write("site/clip.mkv", bytes.replace(at, 4, header(to_ms)));
  }
  std::vector<std::int64_t> Times_ms() const {
    std::vector<std::int64_t> times_ms;
    for (const RawFrame& frame : Read().frames) times_ms.push_back(frame.time_ns / 1'000'000);
    return times_ms;
  }
};

TEST_F(ReadVideoTest, AGapInTimeIsAGap) {
  EXPECT_THAT(Times_ms(), testing::ElementsAre(0, 40, 80, 120, 160, 200));
  for (int i = kNumFrames - 1; i >= 3; --i) Move(i, i * kPeriod_ms + 1000);
  EXPECT_THAT(Times_ms(), testing::ElementsAre(0, 40, 80, 1120, 1160, 1200));
  config_.frame_rate_hz = 10;
  EXPECT_THAT(Times_ms(), testing::ElementsAre(0, 100, 200, 300, 400, 500));
}

TEST_F(ReadVideoTest, TimesThatAreRoundedAreThoseOfTheRate) {
  Move(2, 82);
  Move(4, 157);
  EXPECT_THAT(Times_ms(), testing::ElementsAre(0, 40, 80, 120, 160, 200));
  Move(3, 135);
  EXPECT_THAT(Times_ms(), testing::ElementsAre(0, 40, 82, 135, 157, 200));
}

TEST_F(ReadVideoTest, TimesThatDoNotIncreaseAreThoseOfTheRate) {
  Move(3, 300);
  EXPECT_THAT(Times_ms(), testing::ElementsAre(0, 40, 80, 120, 160, 200));
}

TEST_F(ReadVideoTest, ALastFrameOrTwoMayLackItsPartner) {
  using testing::HasSubstr;
  std::filesystem::remove(folder_ / "site/depth/5.png");
  EXPECT_EQ(Read().frames.size(), 5u);
  EXPECT_THAT(Read().left_out, testing::ElementsAre(HasSubstr("site/clip.mkv#5: left out")));
  std::filesystem::remove(folder_ / "site/depth/4.png");
  const RawSequence sequence = Inspect();
  ASSERT_EQ(sequence.frames.size(), 4u);
  EXPECT_EQ(sequence.frames[3].depth.path, "site/depth/3.png");
  EXPECT_EQ(sequence.left_out.size(), 2u);
  std::filesystem::remove(folder_ / "site/depth/3.png");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "3 depth images for 6 video frames");
  for (int i = 3; i < 8; ++i) WriteDepth(fmt::format("depth/{}.png", i));
  EXPECT_EQ(Read().frames.size(), 6u);
  EXPECT_THAT(Read().left_out,
              testing::ElementsAre(HasSubstr("site/depth/6.png: left out"),
                                   HasSubstr("site/depth/7.png: left out")));
  WriteDepth("depth/8.png");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "9 depth images for 6 video frames of clip.mkv");
  config_.depth = "none";
  EXPECT_EQ(Read().frames.size(), 6u);
}

TEST_F(ReadSequenceTest, DepthIsOptionalWhereTheSiteSaysSo) {
  WriteTum(3);
  folder_.Write("site/depth.txt", "0.11 depth/0.png\n2.11 depth/2.png\n");
  std::filesystem::remove(folder_ / "site/depth/2.png");
  config_.depth = "optional";
  auto sequence = Inspect();
  EXPECT_FALSE(sequence.needs_depth);
  EXPECT_EQ(sequence.frames[0].depth.path, "site/depth/0.png");
  EXPECT_EQ(sequence.frames[1].depth_problem, "");
  EXPECT_EQ(sequence.frames[2].depth_problem, "site/depth/2.png: no such image file");
  EXPECT_EQ(sequence.frames[2].depth.path, "");
  config_.depth = "none";
  sequence = Inspect();
  for (const RawFrame& frame : sequence.frames) EXPECT_EQ(frame.depth.path, "");
  config_.depth = "optional";
  std::filesystem::remove(folder_ / "site/depth.txt");
  EXPECT_EQ(Read().frames.size(), 3u);
}

TEST_F(ReadSequenceTest, PicturesOfWhatMovesAreAChannelOfTheirOwn) {
  WriteTum(4);
  config_.moving_folder = "moves";
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "correct `moving_folder` in site.toml:7");
  std::filesystem::create_directories(folder_ / "site/moves");
  WritePng(folder_ / "site/moves/1.png",
           LabelImage{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight, 255)});
  const auto frames = Inspect().frames;
  EXPECT_TRUE(frames[0].others.empty());
  EXPECT_EQ(frames[1].others.at("moving").path, "site/moves/1.png");
  EXPECT_FALSE(frames[1].others.contains("label"));
}

// A PNG of 32 x 24 pixels of 1 bit, with a palette.
constexpr const char* kPalettePng =
    "89504e470d0a1a0a0000000d4948445200000020000000180103000000a19d6d7700000006504c5445000000"
    "ff804056a054f90000000e4944415478da63f80f040cf427006b425fa1db762de00000000049454e44ae4260"
    "82";

TEST_F(ReadSequenceTest, LabelPicturesMayHaveAPalette) {
  WriteTum(1);
  config_.label_folder = "labels";
  std::string bytes;
  for (std::size_t i = 0; kPalettePng[i] != 0; i += 2) {
    bytes += static_cast<char>(std::stoi(std::string(kPalettePng + i, 2), nullptr, 16));
  }
  std::filesystem::create_directories(folder_ / "site/labels");
  folder_.Write("site/labels/0.png", bytes);
  const auto frames = Inspect().frames;
  EXPECT_TRUE(frames[0].others_problems.empty());
  EXPECT_TRUE(frames[0].others.contains("label"));
}

TEST_F(ReadSequenceTest, LabelPicturesHaveTheStemOfTheColorPicture) {
  WriteTum(4);
  config_.label_folder = "labels";
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "correct `label_folder` in site.toml:7");
  const auto label = [&](const char* name, int width) {
    std::filesystem::create_directories(folder_ / "site/labels");
    const auto num_values = static_cast<std::size_t>(width * kHeight);
    WritePng(folder_ / "site/labels" / name,
             LabelImage{width, kHeight, 1, std::vector<std::uint8_t>(num_values, 15)});
  };
  label("1.png", kWidth);
  label("2.png", kWidth / 2);
  WriteDepth("labels/3.png");
  const auto frames = Inspect().frames;
  EXPECT_TRUE(frames[0].others.empty());
  EXPECT_EQ(frames[1].others.at("label").path, "site/labels/1.png");
  EXPECT_EQ(frames[1].others.at("label").hash.size(), 16u);
  EXPECT_THAT(frames[2].others_problems.at(0), testing::HasSubstr("labels/2.png: 16 x 24 pixels"));
  EXPECT_THAT(frames[3].others_problems.at(0),
              testing::HasSubstr("labels must be one channel of 8 bits, this has 1 of 16"));
  EXPECT_TRUE(frames[2].others.empty() && frames[3].others.empty());
  for (const RawFrame& frame : frames) EXPECT_EQ(frame.problem, "");
}

TEST(AssociateTimes, IsOneToOneNearestFirst) {
  using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
  EXPECT_EQ(AssociateTimes({0, 100, 200}, {10, 95, 290}, 50), (Pairs{{0, 0}, {1, 1}}));
  // Both are in reach of b = 10: the nearer one gets it, and the other takes the remaining one in
  // reach.
  EXPECT_EQ(AssociateTimes({0, 9}, {10, 20}, 25), (Pairs{{0, 1}, {1, 0}}));
  EXPECT_EQ(AssociateTimes({0, 9}, {10}, 25), (Pairs{{1, 0}}));
  EXPECT_EQ(AssociateTimes({0}, {25}, 25).size(), 1u);
  EXPECT_TRUE(AssociateTimes({0}, {26}, 25).empty());
  EXPECT_TRUE(AssociateTimes({}, {1}, 25).empty());
}

TEST(AssociateTimes, NoIndexIsUsedTwiceAndNoGapExceeded) {
  Random random(1);
  std::vector<std::int64_t> a, b;
  for (int i = 0; i < 500; ++i) {
    a.push_back(static_cast<std::int64_t>(random.Index(100000)));
    b.push_back(static_cast<std::int64_t>(random.Index(100000)));
  }
  std::ranges::sort(a);
  std::ranges::sort(b);
  std::vector<int> a_count(a.size()), b_count(b.size());
  for (const auto& [i, j] : AssociateTimes(a, b, 120)) {
    EXPECT_LE(std::abs(a[i] - b[j]), 120);
    EXPECT_EQ(++a_count[i], 1);
    EXPECT_EQ(++b_count[j], 1);
  }
}

}  // namespace nightmap::read_sequence_test
