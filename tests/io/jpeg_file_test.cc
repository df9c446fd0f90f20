// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/io/picture_file.h"
#include "tests/test_data.h"

namespace nightmap::jpeg_file_test {

ColorImage Waves(int width, int height) {
  ColorImage image{width, height, 3, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (const double value : {0.2 * x, 0.3 * y, 0.1 * (x + y)}) {
        image.pixels.push_back(static_cast<std::uint8_t>(128 + 100 * std::sin(value)));
      }
    }
  }
  return image;
}

TEST(EncodeJpeg, APictureIsNearlyWhatItWas) {
  const TemporaryFolder folder;
  const ColorImage image = Waves(61, 43);
  const ColorImage read =
      ReadColorImage(folder.Write("a.jpg", EncodeJpeg(image, 90, JpegColors::kFull)));
  ASSERT_EQ(read.width, 61);
  ASSERT_EQ(read.height, 43);
  double sum = 0;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    sum += std::pow(read.pixels[i] - image.pixels[i], 2);
  }
  EXPECT_LT(std::sqrt(sum / static_cast<double>(image.pixels.size())), 3);
  EXPECT_EQ(EncodeJpeg(image, 90, JpegColors::kFull), EncodeJpeg(image, 90, JpegColors::kFull));
  EXPECT_LT(EncodeJpeg(image, 30, JpegColors::kFull).size(),
            EncodeJpeg(image, 90, JpegColors::kFull).size());
  EXPECT_LT(EncodeJpeg(image, 90, JpegColors::kSubsampled).size(),
            EncodeJpeg(image, 90, JpegColors::kFull).size());
}

TEST(EncodeJpeg, WhatAJpegCannotHoldIsRefused) {
  NIGHTMAP_EXPECT_ERROR(DataError, EncodeJpeg(Waves(65501, 1), 90, JpegColors::kFull), "65501 x 1");
}

}  // namespace nightmap::jpeg_file_test
