// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/picture_file.h"

#include <OpenImageIO/imageio.h>
#include <png.h>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::picture_file_test {

constexpr int kWidth = 37;
constexpr int kHeight = 23;

// A ramp with noise, so that neither compression nor its errors are trivial.
template <typename T>
Image<T> Picture(int num_channels) {
  Image<T> image{kWidth, kHeight, num_channels, {}};
  Random random(1);
  for (int i = 0; i < kWidth * kHeight * num_channels; ++i) {
    image.pixels.push_back(static_cast<T>(97 * i + static_cast<int>(random.Index(60))));
  }
  return image;
}

template <typename T>
void WriteWithLibrary(const std::filesystem::path& path,
                      const Image<T>& image,
                      OIIO::ParamValueList attributes = {}) {
  OIIO::ImageSpec spec(
      image.width, image.height, image.num_channels, OIIO::TypeDesc(OIIO::BaseTypeFromC<T>::value));
  attributes.emplace_back("oiio:UnassociatedAlpha", 1);
  spec.extra_attribs = attributes;
  const auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output && output->open(path.string(), spec) &&
              output->write_image(spec.format, image.pixels.data()) && output->close());
}

template <typename T>
Image<T> ReadWithLibrary(const std::filesystem::path& path) {
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  const auto input = OIIO::ImageInput::open(path.string(), &config);
  const OIIO::ImageSpec& spec = input->spec();
  Image<T> image{spec.width, spec.height, spec.nchannels, {}};
  image.pixels.resize(static_cast<std::size_t>(spec.width * spec.height * spec.nchannels));
  const auto type = OIIO::TypeDesc(OIIO::BaseTypeFromC<T>::value);
  EXPECT_TRUE(input->read_image(0, 0, 0, spec.nchannels, type, image.pixels.data()));
  return image;
}

template <typename T>
void ExpectReadAsByLibrary(PictureFile* file, const std::filesystem::path& path) {
  ASSERT_TRUE(file) << path;
  const Image<T> expected = ReadWithLibrary<T>(path);
  EXPECT_EQ(file->info.width, expected.width);
  EXPECT_EQ(file->info.height, expected.height);
  EXPECT_EQ(file->info.num_channels, expected.num_channels);
  EXPECT_EQ(file->info.num_bits, 8 * sizeof(T));
  std::vector<T> pixels(expected.pixels.size());
  EXPECT_TRUE(file->Read(pixels.data()));
  EXPECT_EQ(pixels, expected.pixels) << path;
}

template <typename T>
class PngFileTest : public testing::Test {};
using Depths = testing::Types<std::uint8_t, std::uint16_t>;
TYPED_TEST_SUITE(PngFileTest, Depths);

TYPED_TEST(PngFileTest, PixelsAreThoseOfTheLibrary) {
  const TemporaryFolder folder;
  for (int num_channels = 1; num_channels <= 4; ++num_channels) {
    const auto image = Picture<TypeParam>(num_channels);
    WriteWithLibrary(folder / "theirs.png", image);
    const auto theirs = OpenPng(ReadBytes(folder / "theirs.png"));
    ExpectReadAsByLibrary<TypeParam>(theirs.get(), folder / "theirs.png");
    const auto ours = folder.Write("ours.png", EncodePng(image));
    EXPECT_EQ(ReadWithLibrary<TypeParam>(ours).pixels, image.pixels) << num_channels;
  }
}

TEST(PngFile, ValuesOfAnotherTypeAreNotRead) {
  std::vector<std::uint8_t> bytes(kWidth * kHeight);
  std::vector<std::uint16_t> words(kWidth * kHeight);
  EXPECT_FALSE(OpenPng(EncodePng(Picture<std::uint16_t>(1)))->Read(bytes.data()));
  EXPECT_FALSE(OpenPng(EncodePng(Picture<std::uint8_t>(1)))->Read(words.data()));
}

TEST(PngFile, WhatAPngCannotHoldIsNoFile) { EXPECT_EQ(EncodePng(GrayImage{0, 4, 1, {}}), ""); }

// A gray PNG of one bit, an interlaced one, and one with a transparent color.
void WriteUnusual(const std::filesystem::path& path, int num_bits, int interlaced, bool has_hole) {
  FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, 8, 8, num_bits, PNG_COLOR_TYPE_GRAY, interlaced, 0, 0);
  png_color_16 hole{};
  hole.gray = 7;
  if (has_hole) png_set_tRNS(png, info, nullptr, 0, &hole);
  png_write_info(png, info);
  std::vector<png_byte> row = {3, 7, 31, 127, 255, 0, 1, 2};
  std::vector<png_bytep> rows(8, row.data());
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

TEST(PngFile, UnusualOnesAreLeftToTheLibrary) {
  const TemporaryFolder folder;
  WriteUnusual(folder / "bits.png", 1, PNG_INTERLACE_NONE, false);
  WriteUnusual(folder / "interlaced.png", 8, PNG_INTERLACE_ADAM7, false);
  WriteUnusual(folder / "hole.png", 8, PNG_INTERLACE_NONE, true);
  for (const char* name : {"bits.png", "interlaced.png", "hole.png"}) {
    EXPECT_FALSE(OpenPng(ReadBytes(folder / name))) << name;
    const Image<std::uint8_t> library = ReadWithLibrary<std::uint8_t>(folder / name);
    const ColorImage image = ReadColorImage(folder / name);
    for (int x = 0; x < 8; ++x) EXPECT_EQ(image.At(x, 5), library.At(x, 5)) << name;
  }
  EXPECT_EQ(ReadColorImage(folder / "interlaced.png").At(2, 5), 31);
}

// 16 x 8 values 0, 1, 2 ..., as many as the bits hold; the colors of the palette are others.
void WriteIndices(const std::filesystem::path& path, int num_bits, int color, int interlaced) {
  FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, 16, 8, num_bits, color, interlaced, 0, 0);
  const std::vector<png_color> palette(std::size_t{1} << num_bits, {255, 128, 64});
  const png_byte alpha = 0;
  if (color == PNG_COLOR_TYPE_PALETTE) {
    png_set_PLTE(png, info, palette.data(), static_cast<int>(palette.size()));
    png_set_tRNS(png, info, &alpha, 1, nullptr);
  }
  png_write_info(png, info);
  png_set_packing(png);
  std::vector<png_byte> values(16 * 8);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<png_byte>(i % palette.size());
  }
  std::vector<png_bytep> rows(8);
  for (std::size_t y = 0; y < 8; ++y) rows[y] = &values[16 * y];
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
}

TEST(PngFile, LabelsAreIndicesAsStored) {
  const TemporaryFolder folder;
  const auto path = folder / "labels.png";
  for (const int color : {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_PALETTE}) {
    for (const int num_bits : {1, 2, 4, 8}) {
      for (const int interlaced : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
        WriteIndices(path, num_bits, color, interlaced);
        const ImageInfo info = InspectLabelImage(path);
        EXPECT_EQ(info.num_channels, 1);
        EXPECT_EQ(info.num_bits, 8);
        const LabelImage labels = ReadLabelImage(path);
        ASSERT_EQ(labels.width, 16);
        ASSERT_EQ(labels.height, 8);
        for (int i = 0; i < 16 * 8; ++i) {
          ASSERT_EQ(labels.At(i % 16, i / 16), i % (1 << num_bits))
              << num_bits << " bits " << color;
        }
      }
    }
  }
}

// The library would decode them to colors.
TEST(PngFile, DamagedIndicesAreRefused) {
  const TemporaryFolder folder;
  for (const int color : {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_PALETTE}) {
    WriteIndices(folder / "labels.png", 4, color, PNG_INTERLACE_NONE);
    std::string bytes = ReadBytes(folder / "labels.png");
    bytes[bytes.find("IDAT") + 6] ^= 0x55;
    const auto damaged = folder.Write("damaged.png", bytes);
    EXPECT_THROW(ReadLabelImage(damaged), DataError) << color;
  }
}

// Their readers scale values of few bits.
TEST(PictureFile, LabelsInOtherFormatsAreRefused) {
  const TemporaryFolder folder;
  folder.Write("labels.png", "P2\n2 1\n15\n0 1\n");
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadLabelImage(folder / "labels.png"),
                        "labels must be PNG files, this is of format pnm");
}

// Each byte of the file in turn: what is read is what the library reads.
TEST(PngFile, DamageIsNotedOrHarmless) {
  const std::string bytes = EncodePng(Picture<std::uint8_t>(1));
  const auto expected = Picture<std::uint8_t>(1).pixels;
  int num_refused = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x55);
    const auto file = OpenPng(damaged);
    if (!file || file->info.width != kWidth || file->info.height != kHeight) {
      ++num_refused;
      continue;
    }
    std::vector<std::uint8_t> pixels(4 * expected.size());
    if (!file->Read(pixels.data())) {
      ++num_refused;
      continue;
    }
    pixels.resize(expected.size());
    EXPECT_EQ(pixels, expected) << i;
  }
  EXPECT_GT(num_refused, static_cast<int>(bytes.size()) * 9 / 10);
}

TEST(JpegFile, PixelsAreThoseOfTheLibrary) {
  const TemporaryFolder folder;
  for (const int num_channels : {1, 3}) {
    for (const char* subsampling : {"4:4:4", "4:2:2", "4:2:0", "4:2:1"}) {
      for (const int is_progressive : {0, 1}) {
        OIIO::ParamValueList attributes;
        attributes.emplace_back("jpeg:subsampling", subsampling);
        attributes.emplace_back("jpeg:progressive", is_progressive);
        WriteWithLibrary(folder / "a.jpg", Picture<std::uint8_t>(num_channels), attributes);
        const auto file = OpenJpeg(ReadBytes(folder / "a.jpg"));
        ExpectReadAsByLibrary<std::uint8_t>(file.get(), folder / "a.jpg");
      }
    }
  }
}

TEST(JpegFile, TheLensIsLeftToTheLibrary) {
  const TemporaryFolder folder;
  OIIO::ParamValueList attributes;
  attributes.emplace_back("Exif:FocalLength", 4.5F);
  WriteWithLibrary(folder / "phone.jpg", Picture<std::uint8_t>(3), attributes);
  EXPECT_TRUE(OpenJpeg(ReadBytes(folder / "phone.jpg"))->has_exif);
  EXPECT_NEAR(InspectImage(folder / "phone.jpg").lens.focal_mm, 4.5, 1e-6);
}

TEST(JpegFile, DamageIsLeftToTheLibrary) {
  const TemporaryFolder folder;
  WriteWithLibrary(folder / "a.jpg", Picture<std::uint8_t>(3));
  std::string bytes = ReadBytes(folder / "a.jpg");
  bytes.replace(bytes.size() / 2, 400, std::string(400, '\0'));
  std::vector<std::uint8_t> pixels(kWidth * kHeight * 3);
  EXPECT_FALSE(OpenJpeg(bytes)->Read(pixels.data()));
}

TEST(PictureFile, RecordingsAreReadAsByTheLibrary) {
  NIGHTMAP_REQUIRE_DATA("hololens_office");
  NIGHTMAP_REQUIRE_DATA("tum_fr1_xyz_15hz");
  const auto png = TestDataPath("hololens_office/depth/00003.png");
  const auto jpeg = TestDataPath("tum_fr1_xyz_15hz/rgb/1305031102.175304.jpg");
  ExpectReadAsByLibrary<std::uint16_t>(OpenPng(ReadBytes(png)).get(), png);
  ExpectReadAsByLibrary<std::uint8_t>(OpenJpeg(ReadBytes(jpeg)).get(), jpeg);
}

TEST(PictureFile, PgmIsReadAsByTheLibrary) {
  const TemporaryFolder folder;
  const auto path = folder.Path() / "a.pgm";
  const auto bytes = Picture<std::uint8_t>(1);
  WriteWithLibrary(path, bytes);
  ExpectReadAsByLibrary<std::uint8_t>(OpenPgm(path, ReadFile(path)).get(), path);
  for (const char* other :
       {"P2\n1 1\n255\n7\n", "P5\n1 1\n100\n7", "P1\n1 1\n0\n", "P6\n1 1\n255\nrgb"}) {
    EXPECT_EQ(OpenPgm(path, other), nullptr) << other;
  }
}

}  // namespace nightmap::picture_file_test
