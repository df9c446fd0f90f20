// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/image_io.h"

#include <OpenImageIO/imageio.h>

#include <opencv2/videoio.hpp>
#include <thread>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::image_io_test {

template <typename T>
Image<T> RandomImage(int width, int height, int num_channels, std::uint64_t seed) {
  Image<T> image{width, height, num_channels, {}};
  image.pixels.resize(static_cast<std::size_t>(width * height * num_channels));
  Random random(seed);
  for (T& value : image.pixels) value = static_cast<T>(random.Next());
  return image;
}

void WriteWithLibrary(const std::filesystem::path& path, const Image<std::uint8_t>& image) {
  auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output);
  const OIIO::ImageSpec spec(image.width, image.height, image.num_channels, OIIO::TypeDesc::UINT8);
  ASSERT_TRUE(output->open(path.string(), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, image.pixels.data()));
  ASSERT_TRUE(output->close());
}

class ImageIo : public InFolder {};

TEST_F(ImageIo, WhatIsWrittenIsRead) {
  const auto color = RandomImage<std::uint8_t>(31, 17, 3, 1);
  const auto gray = RandomImage<std::uint8_t>(8, 5, 1, 2);
  const auto depth = RandomImage<std::uint16_t>(13, 29, 1, 3);
  // A temporary output name has no image extension.
  WritePng(folder_ / "color.tmp", color);
  WritePng(folder_ / "gray.png", gray);
  WritePng(folder_ / "depth.png", depth);
  EXPECT_EQ(ReadColorImage(folder_ / "color.tmp").pixels, color.pixels);
  EXPECT_EQ(ReadLabelImage(folder_ / "gray.png").pixels, gray.pixels);
  const RawDepthImage read = ReadRawDepth(folder_ / "depth.png");
  EXPECT_EQ(read.pixels, depth.pixels);
  EXPECT_EQ(read.width, 13);
  EXPECT_EQ(read.height, 29);
  const ImageInfo info = InspectImage(folder_ / "depth.png");
  EXPECT_EQ(info.width, 13);
  EXPECT_EQ(info.height, 29);
  EXPECT_EQ(info.num_channels, 1);
  EXPECT_EQ(info.num_bits, 16);
}

TEST_F(ImageIo, EqualPixelsGiveEqualBytes) {
  const auto image = RandomImage<std::uint8_t>(40, 30, 3, 4);
  WritePng(folder_ / "a.png", image);
  WritePng(folder_ / "b.png", image);
  EXPECT_EQ(ReadBytes(folder_ / "a.png"), ReadBytes(folder_ / "b.png"));
}

TEST_F(ImageIo, GrayBecomesRgbAndAlphaIsDroppedUnmultiplied) {
  const auto gray = RandomImage<std::uint8_t>(4, 3, 1, 5);
  WritePng(folder_ / "gray.png", gray);
  const ColorImage expanded = ReadColorImage(folder_ / "gray.png");
  ASSERT_EQ(expanded.num_channels, 3);
  for (const int channel : {0, 2}) EXPECT_EQ(expanded.At(2, 1, channel), gray.At(2, 1));
  Image<std::uint8_t> rgba{1, 1, 4, {200, 100, 50, 128}};
  WritePng(folder_ / "rgba.png", rgba);
  const auto dropped = ReadColorImage(folder_ / "rgba.png");
  EXPECT_EQ(dropped.num_channels, 3);
  EXPECT_EQ(dropped.pixels, (std::vector<std::uint8_t>{200, 100, 50}));
}

TEST_F(ImageIo, GrayIsLuma) {
  const ColorImage image{3, 1, 3, {255, 255, 255, 255, 0, 0, 0, 255, 0}};
  EXPECT_EQ(ToGray(image).pixels, (std::vector<std::uint8_t>{255, 76, 150}));
}

TEST_F(ImageIo, MissingOrForeignFileIsNamed) {
  NIGHTMAP_EXPECT_ERROR(
      DataError, ReadColorImage(folder_ / "no.png"), "no.png: no such image file");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadColorImage(folder_.Write("a.png", "")), "a.png");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadColorImage(folder_.Write("b.png", "hello")), "b.png");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadColorImage(folder_.Path()), "not a file");
}

TEST_F(ImageIo, DepthMustBeOneChannelOf16Bits) {
  WritePng(folder_ / "8.png", RandomImage<std::uint8_t>(4, 4, 1, 6));
  WritePng(folder_ / "rgb.png", RandomImage<std::uint16_t>(4, 4, 3, 7));
  NIGHTMAP_EXPECT_ERROR(DataError, ReadRawDepth(folder_ / "8.png"), "one channel of 16 bits");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadRawDepth(folder_ / "rgb.png"), "one channel of 16 bits");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadLabelImage(folder_ / "rgb.png"), "one channel of 8 bits");
}

// Refused by what the header declares, so that it does not depend on the machine whose memory a
// picture does not fit.
TEST_F(ImageIo, APictureThatIsTooLargeIsRefusedByItsHeader) {
  const auto path = folder_.Write("large.ppm", "P6\n32768 32768\n255\n");
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadColorImage(path),
                        "large.ppm: header says 32768 x 32768 pixels of 3 channels, more than "
                        "1073741824 values; make the picture smaller");
}

// It has the size of a recording and the first bytes of a picture; sparse, so it takes no room.
TEST_F(ImageIo, AFileTooLargeForAPictureIsNotReadWhole) {
  WritePng(folder_ / "large.png", RandomImage<std::uint8_t>(4, 4, 1, 6));
  std::filesystem::resize_file(folder_ / "large.png", std::uintmax_t{1} << 40);
  NIGHTMAP_EXPECT_ERROR(DataError, InspectImage(folder_ / "large.png"), "large.png: truncated png");
}

TEST_F(ImageIo, TruncationIsDetectedAtEveryLength) {
  WritePng(folder_ / "whole.png", RandomImage<std::uint16_t>(24, 18, 1, 8));
  WriteWithLibrary(folder_ / "whole.jpg", RandomImage<std::uint8_t>(64, 48, 3, 9));
  for (const char* name : {"whole.png", "whole.jpg"}) {
    const std::string bytes = ReadBytes(folder_ / name);
    ASSERT_GT(bytes.size(), 500u);
    ASSERT_NO_THROW(InspectImage(folder_ / name));
    for (std::size_t length = 0; length + 1 < bytes.size(); length += 41) {
      const auto cut = folder_.Write(std::string("cut_") + name, bytes.substr(0, length));
      ASSERT_THROW(ReadColorImage(cut), DataError) << name << " of " << length << " bytes";
      ASSERT_THROW(InspectImage(cut), DataError) << name << " of " << length << " bytes";
    }
  }
}

TEST_F(ImageIo, TrailingBytesAreTolerated) {
  WritePng(folder_ / "a.png", RandomImage<std::uint8_t>(9, 9, 3, 10));
  const auto padded = folder_.Write("b.png", ReadBytes(folder_ / "a.png") + std::string(512, '\0'));
  EXPECT_EQ(ReadColorImage(padded).pixels, ReadColorImage(folder_ / "a.png").pixels);
}

TEST_F(ImageIo, DamagedBytesNeverGiveAnImageOfAnotherSize) {
  WritePng(folder_ / "a.png", RandomImage<std::uint8_t>(20, 20, 3, 11));
  const std::string bytes = ReadBytes(folder_ / "a.png");
  Random random(12);
  int num_refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string damaged = bytes;
    damaged[random.Index(damaged.size())] ^= static_cast<char>(1 + random.Index(255));
    const auto path = folder_.Write("damaged.png", damaged);
    try {
      const ColorImage image = ReadColorImage(path);
      ASSERT_EQ(image.pixels.size(),
                static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3);
    } catch (const DataError&) {
      ++num_refused;
    }
  }
  EXPECT_GT(num_refused, 200);
}

TEST_F(ImageIo, TruncatedRecordingIsRefused) {
  NIGHTMAP_REQUIRE_DATA("hololens_office");
  NIGHTMAP_REQUIRE_DATA("tum_fr1_xyz_15hz");
  const auto png = ReadBytes(TestDataPath("hololens_office/depth/00003.png"));
  const auto jpg = ReadBytes(TestDataPath("tum_fr1_xyz_15hz/rgb/1305031102.175304.jpg"));
  ASSERT_NO_THROW(ReadRawDepth(folder_.Write("whole.png", png)));
  ASSERT_NO_THROW(ReadColorImage(folder_.Write("whole.jpg", jpg)));
  const auto cut_png = folder_.Write("cut.png", png.substr(0, png.size() / 2));
  const auto cut_jpg = folder_.Write("cut.jpg", jpg.substr(0, jpg.size() / 2));
  NIGHTMAP_EXPECT_ERROR(DataError, ReadRawDepth(cut_png), "cut.png: truncated png file");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadColorImage(cut_jpg), "cut.jpg: truncated jpeg file");
}

class VideoTest : public testing::Test {
 protected:
  static constexpr int kNumFrames = 12;

  // Frame i is uniformly gray of value 10 + 20 i.
  void SetUp() override {
    cv::VideoWriter writer((folder_ / "clip.avi").string(),
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                           15.0,
                           cv::Size(64, 48));
    ASSERT_TRUE(writer.isOpened());
    for (int i = 0; i < kNumFrames; ++i) {
      writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(10 + 20 * i)));
    }
  }
  void ExpectFrame(int i) const {
    const ColorImage image = ReadColorImage(VideoFramePath(folder_ / "clip.avi", i));
    ASSERT_EQ(image.width, 64);
    EXPECT_NEAR(image.At(30, 20, 1), 10 + 20 * i, 4) << i;
  }
  TemporaryFolder folder_;
};

TEST_F(VideoTest, FramesAreReachedInAnyOrderFromAnyThread) {
  const VideoInfo info = InspectVideo(folder_ / "clip.avi");
  EXPECT_EQ(info.num_frames, kNumFrames);
  EXPECT_EQ(info.width, 64);
  EXPECT_EQ(info.height, 48);
  EXPECT_DOUBLE_EQ(info.frame_rate_hz, 15);
  for (const int i : {0, 1, 2, 7, 7, 3, 11, 0}) ExpectFrame(i);
  std::thread other([&] {
    for (int i = 0; i < kNumFrames; ++i) ExpectFrame(i);
  });
  for (int i = kNumFrames - 1; i >= 0; --i) ExpectFrame(i);
  other.join();
}

// Reads as the stages do: batch after batch, each on new threads.
TEST_F(VideoTest, BatchesOfThreadsDecodeEachFrameOnce) {
  std::vector<std::vector<std::uint8_t>> expected;
  for (const int num_threads : {1, 4}) {
    const auto clip = folder_ / fmt::format("copy_{}.avi", num_threads);
    std::filesystem::copy_file(folder_ / "clip.avi", clip);
    const std::int64_t num_before = NumDecodedVideoFrames();
    std::vector<std::vector<std::uint8_t>> pixels(kNumFrames);
    for (std::size_t begin = 0; begin < kNumFrames; begin += 4) {
      ParallelFor(4, num_threads, [&](std::size_t i) {
        const int frame_idx = static_cast<int>(begin + i);
        pixels[begin + i] = ReadColorImage(VideoFramePath(clip, frame_idx)).pixels;
      });
    }
    const std::int64_t num_decoded = NumDecodedVideoFrames() - num_before;
    // A thread that comes late opens another reader, which goes through the video too.
    EXPECT_LE(num_decoded, num_threads * kNumFrames);
    EXPECT_GE(num_decoded, kNumFrames);
    if (expected.empty()) expected = pixels;
    EXPECT_EQ(pixels, expected);
  }
}

TEST_F(VideoTest, FramesBeyondTheEndAndForeignFilesAreRefused) {
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadColorImage(VideoFramePath(folder_ / "clip.avi", kNumFrames)),
                        "12 readable frames, no frame 12");
  ExpectFrame(3);  // still readable after the error
  NIGHTMAP_EXPECT_ERROR(DataError, ReadColorImage(folder_ / "no.avi#0"), "no such video");
  NIGHTMAP_EXPECT_ERROR(DataError, InspectVideo(folder_.Write("text.avi", "hello")), "text.avi");
}

TEST_F(ImageIo, VideoFramePathsAreTakenApart) {
  const auto parts = SplitVideoFramePath("a/clip#1.avi#17");
  ASSERT_TRUE(parts);
  EXPECT_EQ(parts->first, "a/clip#1.avi");
  EXPECT_EQ(parts->second, 17);
  for (const char* path : {"a/clip.avi", "a/clip.avi#", "a/clip.avi#-1", "a#1/b.png"}) {
    EXPECT_FALSE(SplitVideoFramePath(path)) << path;
  }
}

}  // namespace nightmap::image_io_test
