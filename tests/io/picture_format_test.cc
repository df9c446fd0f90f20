// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/picture_format.h"

#include <OpenImageIO/imageio.h>

#include <opencv2/videoio.hpp>

#include "pipeline/base/error.h"
#include "pipeline/io/image_io.h"
#include "tests/test_data.h"

namespace nightmap::picture_format_test {

using namespace std::string_literals;

constexpr int kWidth = 9;
constexpr int kHeight = 6;

// A picture in the format that the suffix names; false when OpenImageIO cannot write it here.
bool WritePicture(const std::filesystem::path& path, const OIIO::ParamValueList& attributes = {}) {
  OIIO::ImageSpec spec(kWidth, kHeight, 3, OIIO::TypeDesc::UINT8);
  spec.extra_attribs = attributes;
  const std::vector<std::uint8_t> pixels(kWidth * kHeight * 3, 90);
  const auto output = OIIO::ImageOutput::create(path.string());
  return output && output->open(path.string(), spec) &&
         output->write_image(OIIO::TypeDesc::UINT8, pixels.data()) && output->close();
}

class PictureFormat : public InFolder {};

TEST_F(PictureFormat, APictureIsOfTheFormatThatItsFirstBytesSay) {
  const std::pair<const char*, const char*> formats[] = {{"jpg", "jpeg"},
                                                         {"png", "png"},
                                                         {"tif", "tiff"},
                                                         {"bmp", "bmp"},
                                                         {"ppm", "pnm"},
                                                         {"webp", "webp"},
                                                         {"exr", "openexr"}};
  for (const auto& [suffix, format] : formats) {
    const auto path = folder_ / (std::string("a.") + suffix);
    ASSERT_TRUE(WritePicture(path)) << suffix;
    EXPECT_EQ(FormatOfFile(path), format);
    // The suffix of another format, and of a video, change nothing.
    for (const char* name : {"b.png", "b.mp4", "b.dcm", "b"}) {
      std::filesystem::copy_file(
          path, folder_ / name, std::filesystem::copy_options::overwrite_existing);
      const ColorImage image = ReadColorImage(folder_ / name);
      EXPECT_EQ(image.width, kWidth) << suffix << " as " << name;
      EXPECT_EQ(image.height, kHeight) << suffix << " as " << name;
    }
  }
}

TEST_F(PictureFormat, WhatNoWriterHereWritesIsKnownByItsFirstBytes) {
  EXPECT_EQ(FormatOfPicture("MM\0*\0\0\0\x08"s), "tiff");
  EXPECT_EQ(FormatOfPicture("II+\0\x08\0\0\0"s), "tiff");
  EXPECT_EQ(FormatOfPicture("MM\0+\0\x08\0\0"s), "tiff");
  for (const char* brand : {"heic", "heix", "hevc", "mif1", "msf1", "avif"}) {
    const std::string start = "\0\0\0\x18"s + "ftyp" + brand;
    EXPECT_EQ(FormatOfPicture(start), "heif") << brand;
    EXPECT_FALSE(IsVideo(start)) << brand;
  }
  EXPECT_EQ(FormatOfPicture(""), "");
  EXPECT_EQ(FormatOfPicture("\x89PNG"), "");
  EXPECT_EQ(FormatOfPicture("RIFF1234WAVE"), "");
}

TEST_F(PictureFormat, AVideoIsKnownByItsFirstBytes) {
  for (const char* brand : {"isom", "mp42", "qt  ", "M4V ", "3gp5"}) {
    EXPECT_TRUE(IsVideo("\0\0\0\x18"s + "ftyp" + brand)) << brand;
  }
  const std::string packet = "G" + std::string(187, '\0');
  for (const std::string& start : {"\0\0\0\x08wide"s,
                                   "\0\0\0\x08moov"s,
                                   "RIFF1234AVI LIST"s,
                                   "\x1A\x45\xDF\xA3"s,
                                   "GIF89a"s,
                                   "\x30\x26\xB2\x75\x8E\x66\xCF\x11"s,
                                   "\0\0\x01\xBA"s,
                                   "\0\0\x01\xB3"s,
                                   "FLV\x01"s,
                                   "OggS"s,
                                   packet + packet,
                                   "\0\0\0\0"s + packet + "\0\0\0\0"s + packet}) {
    EXPECT_TRUE(IsVideo(start)) << start;
    EXPECT_EQ(FormatOfPicture(start), "") << start;
  }
  EXPECT_FALSE(IsVideo(""));
  EXPECT_FALSE(IsVideo(packet));
  EXPECT_FALSE(IsVideo("Good morning" + std::string(300, ' ')));
}

void ExpectRefused(const std::filesystem::path& path, const std::string& why) {
  NIGHTMAP_EXPECT_ERROR(DataError, InspectImage(path), why);
  NIGHTMAP_EXPECT_ERROR(DataError, ReadColorImage(path), why);
  NIGHTMAP_EXPECT_ERROR(DataError, ReadRawDepth(path), why);
  NIGHTMAP_EXPECT_ERROR(DataError, ReadLabelImage(path), why);
}

// OpenImageIO reads videos too, and answers with their first frame.
TEST_F(PictureFormat, AVideoIsNoPictureWhateverItsName) {
  for (const char* movie : {"clip.avi", "clip.mp4", "clip.mkv"}) {
    cv::VideoWriter writer((folder_ / movie).string(),
                           cv::CAP_FFMPEG,
                           cv::VideoWriter::fourcc('m', 'p', '4', 'v'),
                           15.0,
                           cv::Size(64, 48));
    ASSERT_TRUE(writer.isOpened()) << movie;
    for (int i = 0; i < 5; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(50 * i)));
    writer.release();
    ExpectRefused(folder_ / movie, std::string(movie) + ": is a video or an animation");
    std::filesystem::rename(folder_ / movie, folder_ / "holiday.jpg");
    ExpectRefused(folder_ / "holiday.jpg", "extract the frames to localize as pictures");
  }
}

// OpenImageIO has readers of many other formats, which nobody's camera writes.
TEST_F(PictureFormat, OtherFormatsOfTheLibraryAreNotOpened) {
  int num_written = 0;
  for (const char* name : {"a.hdr", "a.sgi", "a.tga", "a.fits", "a.ico", "a.dpx", "a.rla"}) {
    if (!WritePicture(folder_ / name)) continue;
    ++num_written;
    ExpectRefused(folder_ / name, std::string(name) + ": is no picture of a known format (PNG");
    std::filesystem::rename(folder_ / name, folder_ / "b.png");
    ExpectRefused(folder_ / "b.png", "convert it to PNG or JPEG");
  }
  EXPECT_GE(num_written, 4);
}

TEST_F(PictureFormat, TheSizesOfAHeifFileAreCheckedBeforeItIsOpened) {
  const std::string start = "\0\0\0\x18"s + "ftypheic" + "\0\0\0\0mif1heic"s;
  const std::string box = "\0\0\0\x14ispe\0\0\0\0"s;
  EXPECT_NO_THROW(CheckHeifSizes("a.heic", start + box + "\0\0\x0F\xC0\0\0\x0B\xD0"s));
  EXPECT_NO_THROW(CheckHeifSizes("a.heic", start + box + "\0\0\x0F"s));  // left to the library
  const auto large = folder_.Write(
      "a.heic", start + box + "\0\0\x02\0\0\0\x02\0"s + box + "\0\0\x80\0\0\0\x80\0"s);
  NIGHTMAP_EXPECT_ERROR(DataError, InspectImage(large), "a.heic: header says 32768 x 32768 pixels");
  const auto wide = folder_.Write("b.heic", start + box + "\0\0\x80\x01\0\0\0\x01"s);
  NIGHTMAP_EXPECT_ERROR(DataError, ReadColorImage(wide), "b.heic: header says 32769 x 1 pixels");
}

}  // namespace nightmap::picture_format_test
