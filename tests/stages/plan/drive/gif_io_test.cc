// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/gif_io.h"

#include <OpenImageIO/imageio.h>

#include "pipeline/base/files.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::gif_io_test {

constexpr int kWidth = 40, kHeight = 20;

// Spots of many colors that come and go, the worst for whoever chooses colors or dithers.
std::vector<ColorImage> Drawings(int num_images, int num_colors) {
  Random random(7);
  const auto draw = [&](int count) { return static_cast<int>(random.Uniform(0, count)); };
  std::vector<ColorImage> images(static_cast<std::size_t>(num_images));
  ColorImage image{kWidth, kHeight, 3, {}};
  image.pixels.assign(3 * kWidth * kHeight, 255);
  for (int i = 0; i < num_images; ++i) {
    for (int spot = 0; spot < 30 && i != 2; ++spot) {  // the third is as the second
      const int x = draw(kWidth), y = draw(kHeight), color = draw(num_colors - 1);
      image.At(x, y, 0) = static_cast<std::uint8_t>(color);
      image.At(x, y, 1) = static_cast<std::uint8_t>(color * 7);
      image.At(x, y, 2) = 3;
    }
    images[static_cast<std::size_t>(i)] = image;
  }
  return images;
}

TEST(GifIo, AnimationKeepsEveryPixelAndTheTimes) {
  const TemporaryFolder folder;
  for (const int num_colors : {2, 9, 200}) {
    const auto images = Drawings(6, num_colors);
    WriteGif(folder / "a.tmp", images, 5);
    WriteGif(folder / "b.gif", images, 5);
    EXPECT_EQ(ReadFile(folder / "a.tmp"), ReadFile(folder / "b.gif"));
    const auto input = OIIO::ImageInput::open((folder / "b.gif").string());
    ASSERT_TRUE(input);
    for (int i = 0; i < 6; ++i) {
      ASSERT_TRUE(input->seek_subimage(i, 0));
      EXPECT_NEAR(input->spec().get_float_attribute("FramesPerSecond"), 5, 0.01);
      const int num_channels = input->spec().nchannels;
      ASSERT_GE(num_channels, 3);
      ColorImage read{kWidth, kHeight, 3, std::vector<std::uint8_t>(3 * kWidth * kHeight)};
      ASSERT_TRUE(input->read_image(i, 0, 0, 3, OIIO::TypeDesc::UINT8, read.pixels.data()));
      EXPECT_EQ(read.pixels, images[static_cast<std::size_t>(i)].pixels) << i;
    }
    EXPECT_FALSE(input->seek_subimage(6, 0));
  }
}

TEST(GifIo, MistakesAreErrors) {
  const TemporaryFolder folder;
  auto images = Drawings(2, 3);
  NIGHTMAP_EXPECT_ERROR(DataError, WriteGif(folder / "none" / "c.gif", images, 5), "c.gif");
  NIGHTMAP_EXPECT_ERROR(DataError, WriteGif(folder / "c.gif", {}, 5), "needs an image");
  for (std::size_t i = 0; i < images[0].pixels.size(); ++i) {
    images[0].pixels[i] = static_cast<std::uint8_t>(i / 3);
    images[1].pixels[i] = static_cast<std::uint8_t>(i % 251);
  }
  NIGHTMAP_EXPECT_ERROR(DataError, WriteGif(folder / "c.gif", images, 5), "at most 256 colors");
  images[1] = ColorImage{1, 1, 3, {0, 0, 0}};
  NIGHTMAP_EXPECT_ERROR(DataError, WriteGif(folder / "c.gif", images, 5), "one size");
  EXPECT_FALSE(std::filesystem::exists(folder / "c.gif"));
}

}  // namespace nightmap::gif_io_test
