// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/resize_picture.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"

namespace nightmap::resize_picture_test {

const Camera kCamera{1000, 600, 810, 790, 480, 310, -0.2, 0.05, 0.001, -0.002, 0.01};

ColorImage Blank(int width, int height) {
  ColorImage image{width, height, 3, {}};
  image.pixels.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  return image;
}

// Red grows to the right, green downwards.
ColorImage Ramp(int width, int height) {
  ColorImage image = Blank(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.At(x, y, 0) = static_cast<std::uint8_t>(2 * x);
      image.At(x, y, 1) = static_cast<std::uint8_t>(2 * y);
    }
  }
  return image;
}

TEST(ResizePicture, APointIsSeenAtTheScaledPixel) {
  const Camera resized = ResizeCamera(kCamera, 250, 200);
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d point(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(2, 5));
    const auto before = kCamera.Project(point);
    const auto after = resized.Project(point);
    ASSERT_TRUE(before && after);
    EXPECT_NEAR(after->x(), (before->x() + 0.5) / 4 - 0.5, 1e-9);
    EXPECT_NEAR(after->y(), (before->y() + 0.5) / 3 - 0.5, 1e-9);
    EXPECT_LT((ResizePixel(*before, kCamera, resized) - *after).norm(), 1e-9);
    EXPECT_LT((ResizePixel(*after, resized, kCamera) - *before).norm(), 1e-9);
    EXPECT_EQ(ResizePixel(*before, kCamera, kCamera), *before);
  }
}

// The centre of the whole picture stays so; back and forth is the same camera.
TEST(ResizePicture, TheEdgesOfThePictureStay) {
  const Camera camera{640, 480, 525, 525, 319.5, 239.5};
  const Camera resized = ResizeCamera(camera, 160, 120);
  EXPECT_DOUBLE_EQ(resized.cx, 79.5);
  EXPECT_DOUBLE_EQ(resized.cy, 59.5);
  const Camera again = ResizeCamera(resized, 640, 480);
  EXPECT_NEAR(again.cx, camera.cx, 1e-12);
  EXPECT_NEAR(again.fy, camera.fy, 1e-12);
}

// A ramp is still the same ramp, in the pixels that the resized camera says; at a whole and at a
// broken scale.
TEST(ResizePicture, ContentFollowsTheCamera) {
  const Camera camera{120, 96, 100, 100, 59.5, 47.5};
  for (const double scale : {0.25, 0.4, 0.73}) {
    const CameraPicture small = ShrinkPicture(Ramp(120, 96), camera, scale);
    EXPECT_EQ(small.color.width, small.camera.width);
    EXPECT_EQ(small.color.height, small.camera.height);
    EXPECT_NEAR(small.color.width, 120 * scale, 0.5);
    for (int y = 0; y < small.color.height; ++y) {
      for (int x = 0; x < small.color.width; ++x) {
        const auto pixel = camera.Project(small.camera.BackProject({x, y}, 1));
        EXPECT_NEAR(small.color.At(x, y, 0), 2 * pixel->x(), 1) << scale;
        EXPECT_NEAR(small.color.At(x, y, 1), 2 * pixel->y(), 1) << scale;
        EXPECT_EQ(small.color.At(x, y, 2), 0);
      }
    }
  }
}

// No pixel of a fine pattern is passed over, as by plain interpolation.
TEST(ResizePicture, EveryPixelCounts) {
  ColorImage image = Blank(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) image.At(x, y, 0) = x % 4 == 0 && y % 4 == 0 ? 160 : 0;
  }
  const CameraPicture small = ShrinkPicture(image, {64, 64, 50, 50, 31.5, 31.5}, 0.25);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) EXPECT_EQ(small.color.At(x, y, 0), 10);
  }
}

// A sample lies within half a pixel of where the resized camera sees it.
TEST(ResizePicture, SamplesLieAtTheCentreOfPixels) {
  const Camera camera{120, 96, 100, 100, 59.5, 47.5};
  Image<int> image{120, 96, 1, {}};
  for (int i = 0; i < 120 * 96; ++i) image.pixels.push_back(i);
  EXPECT_EQ(SampleImage(image, 120, 96).pixels, image.pixels);
  for (const auto& [width, height] : {std::pair{40, 32}, {50, 70}, {240, 192}}) {
    const Camera resized = ResizeCamera(camera, width, height);
    const Image<int> sampled = SampleImage(image, width, height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const auto pixel = ResizePixel(Eigen::Vector2d(x, y), resized, camera);
        ASSERT_NEAR(sampled.At(x, y) % 120, pixel.x(), 0.5 + 1e-9) << width;
        ASSERT_NEAR(sampled.At(x, y) / 120, pixel.y(), 0.5 + 1e-9) << width;
      }
    }
  }
}

TEST(ResizePicture, AtLeastOnePixelStays) {
  const CameraPicture small = ShrinkPicture(Blank(40, 3), {40, 3, 50, 50, 19.5, 1}, 0.01);
  EXPECT_EQ(small.color.width, 1);
  EXPECT_EQ(small.color.height, 1);
  EXPECT_EQ(small.color.pixels.size(), 3U);
}

}  // namespace nightmap::resize_picture_test
