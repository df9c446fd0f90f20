// SPDX-License-Identifier: Apache-2.0
// Facts that a container has of its frames beside pixels: when they were taken, how to turn them.

#include <opencv2/videoio.hpp>

#include "pipeline/base/error.h"
#include "pipeline/io/image_io.h"
#include "tests/test_data.h"

namespace nightmap::video_test {

using namespace std::string_literals;

// Ten frames at 20 Hz, bright on the left.
std::string VideoBytes(const TemporaryFolder& folder,
                       const std::string& name,
                       const std::string& codec = "mp4v") {
  cv::VideoWriter writer((folder / name).string(),
                         cv::CAP_FFMPEG,
                         cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]),
                         20.0,
                         cv::Size(64, 48));
  EXPECT_TRUE(writer.isOpened());
  cv::Mat picture(48, 64, CV_8UC3, cv::Scalar::all(20));
  picture.colRange(0, 32) = cv::Scalar::all(220);
  for (int i = 0; i < 10; ++i) writer.write(picture);
  writer.release();
  return ReadBytes(folder / name);
}

// The display matrix of the track header (ISO/IEC 14496-12), which is the identity.
std::string Turned(std::string bytes,
                   const std::string& a,
                   const std::string& b,
                   const std::string& c,
                   const std::string& d) {
  const std::string zero(4, '\0'), one = "\0\1\0\0"s;
  const std::size_t track = bytes.find("tkhd");
  const std::size_t at = bytes.find(one + zero + zero + zero + one, track);
  EXPECT_LT(at, track + 60);
  return bytes.replace(at, 20, a + b + zero + c + d);
}

TEST(Video, ADisplayRotationTurnsNeitherPixelsNorSize) {
  const TemporaryFolder folder;
  const std::string bytes = VideoBytes(folder, "clip.mp4");
  const std::string zero(4, '\0'), one = "\0\1\0\0"s, minus = "\xFF\xFF\0\0"s;
  folder.Write("180.mp4", Turned(bytes, minus, zero, zero, minus));
  folder.Write("90.mp4", Turned(bytes, zero, one, minus, zero));
  for (const char* name : {"clip.mp4", "180.mp4", "90.mp4"}) {
    const VideoInfo info = InspectVideo(folder / name);
    EXPECT_EQ(info.width, 64) << name;
    EXPECT_EQ(info.height, 48) << name;
    const ColorImage image = ReadColorImage(VideoFramePath(folder / name, 3));
    ASSERT_EQ(image.width, 64) << name;
    EXPECT_GT(image.At(8, 40), 180) << name;
    EXPECT_LT(image.At(56, 8), 60) << name;
  }
}

TEST(Video, TimesAreThoseOfTheContainer) {
  const TemporaryFolder folder;
  // H.264 reorders frames: the decoder gives the last ones after the end of the file.
  for (const auto& [name, codec] : {std::pair{"clip.mp4", "mp4v"},
                                    {"clip.mkv", "mp4v"},
                                    {"clip.avi", "mp4v"},
                                    {"reordered.mp4", "avc1"},
                                    {"reordered.mkv", "avc1"}}) {
    VideoBytes(folder, name, codec);
    const VideoInfo info = InspectVideo(folder / name);
    ASSERT_EQ(info.times_ns.size(), 10U) << name;
    for (int i = 0; i < 10; ++i) {
      EXPECT_NEAR(static_cast<double>(info.times_ns[static_cast<std::size_t>(i)]), 5e7 * i, 1e6)
          << name;
    }
  }
}

}  // namespace nightmap::video_test
