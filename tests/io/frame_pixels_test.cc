// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/error.h"
#include "tests/io/some_frames.h"
#include "tests/test_data.h"

namespace nightmap::frame_pixels_test {

template <typename T>
Image<T> Constant(T value, int width = 40, int height = 30, int num_channels = 1) {
  const auto num_values = static_cast<std::size_t>(width * height * num_channels);
  return {width, height, num_channels, std::vector<T>(num_values, value)};
}

// A plane 2 m ahead of SomeCamera, as a sensor sees it that measures along its rays.
RawDepthImage TwoMetresAlongTheRay(const Camera& picture) {
  RawDepthImage raw{picture.width, picture.height, 1, {}};
  for (int i = 0; i < picture.width * picture.height; ++i) {
    const Eigen::Vector2d pixel(i % picture.width, i / picture.width);
    const double units = picture.BackProject(pixel, 2.0).norm() * SomeCamera().depth_units_per_m;
    raw.pixels.push_back(static_cast<std::uint16_t>(std::lround(units)));
  }
  return raw;
}

// A frame of the pictures c.png and d.png.
class FramePixels : public testing::Test {
 protected:
  FramePixels() {
    frame_.color.path = "c.png";
    frame_.depth.path = "d.png";
  }
  ColorImage Color() const { return LoadColor(frame_, camera_, folder_.Path()); }
  DepthImage Depth() const { return LoadDepth(frame_, camera_, folder_.Path()); }
  RgbdImages Rgbd() const { return LoadRgbd(frame_, camera_, folder_.Path()); }

  TemporaryFolder folder_;
  RgbdCamera camera_ = SomeCamera();
  FrameRecord frame_;
};

TEST_F(FramePixels, DepthIsInMetresWithinTheRange) {
  RawDepthImage raw = Constant<std::uint16_t>(10000);
  raw.At(1, 0) = 0;
  raw.At(2, 0) = 65535;
  raw.At(3, 0) = 1499;   // 0.2998 m, too near
  raw.At(4, 0) = 22501;  // 4.5002 m, too far
  raw.At(5, 0) = 22500;
  WritePng(folder_ / "d.png", raw);
  const DepthImage depth = Depth();
  EXPECT_FLOAT_EQ(depth.At(0, 0), 2.0f);
  for (int x = 1; x <= 4; ++x) EXPECT_EQ(depth.At(x, 0), 0.0f) << x;
  EXPECT_FLOAT_EQ(depth.At(5, 0), 4.5f);
}

TEST_F(FramePixels, DistancesAlongTheRayBecomeZ) {
  WritePng(folder_ / "d.png", TwoMetresAlongTheRay(camera_.color));
  EXPECT_GT(Depth().At(0, 0), 2.1f);
  camera_.depth_along_ray = true;
  const DepthImage depth = Depth();
  for (const float z : depth.pixels) ASSERT_NEAR(z, 2.0, 1.0 / camera_.depth_units_per_m);
}

TEST_F(FramePixels, WhatTheSensorMeasuresTooFarIsTakenOff) {
  WritePng(folder_ / "d.png", Constant<std::uint16_t>(2000));
  camera_.depth_units_per_m = 1000;
  camera_.depth_offset_m = 0.125;
  EXPECT_FLOAT_EQ(Depth().At(3, 4), 1.875f);
  camera_.depth_offset_m = 2.5;  // nothing is nearer than the camera
  EXPECT_EQ(Depth().At(3, 4), 0);
}

TEST_F(FramePixels, UnsureDepthIsNotMeasured) {
  camera_.min_confidence = 2;
  WritePng(folder_ / "d.png", Constant<std::uint16_t>(10000));
  NIGHTMAP_EXPECT_ERROR(DataError, Depth(), "d.png: no picture of its confidence is listed");
  frame_.others[kConfidenceChannel].path = "sure.png";
  NIGHTMAP_EXPECT_ERROR(DataError, Depth(), "sure.png: no such image file");
  for (const int factor : {1, 2, 5}) {
    GrayImage sure{40 / factor, 30 / factor, 1, {}};
    for (int i = 0; i < sure.width * sure.height; ++i) {
      sure.pixels.push_back(static_cast<std::uint8_t>(i % 4));
    }
    WritePng(folder_ / "sure.png", sure);
    const DepthImage depth = Depth();
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 40; ++x) {
        ASSERT_EQ(depth.At(x, y), sure.At(x / factor, y / factor) < 2 ? 0.0f : 2.0f)
            << x << " " << y;
      }
    }
  }
  WritePng(folder_ / "sure.png", Constant<std::uint8_t>(2, 20, 30, 1));
  NIGHTMAP_EXPECT_ERROR(DataError, Depth(), "sure.png: 20 x 30 pixels, its depth has 40 x 30");
  const std::string png = ReadBytes(folder_ / "sure.png");
  folder_.Write("sure.png", png.substr(0, png.size() - 20));
  NIGHTMAP_EXPECT_ERROR(DataError, Depth(), "sure.png: truncated png file: copy it again");
}

TEST_F(FramePixels, SixteenBitsAreScaledByThoseInUse) {
  Image<std::uint16_t> gray = Constant<std::uint16_t>(0);
  for (std::size_t i = 0; i < 1024; ++i) gray.pixels[i] = static_cast<std::uint16_t>(i);
  WritePng(folder_ / "c.png", gray);
  const auto load = [&](int num_bits) {
    camera_.picture_bits = num_bits;
    return Color();
  };
  for (const int num_bits : {10, 12, 16}) {
    const ColorImage color = load(num_bits);
    for (std::size_t i = 0; i < 1024; ++i) {
      const double expected = 255.0 * static_cast<double>(i) / ((1 << num_bits) - 1);
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_NEAR(color.pixels[3 * i + c], expected, 0.5) << num_bits << " bits: " << i;
      }
    }
  }
  NIGHTMAP_EXPECT_ERROR(
      DataError, load(9), "c.png: a value is 512, more than picture_bits = 9 bits hold: raise");
  WritePng(folder_ / "c.png", Constant<std::uint8_t>(200));
  EXPECT_EQ(load(10).At(0, 0), 200);  // a picture of 8 bits
}

TEST_F(FramePixels, SeenSmallerColorIsTheMeanAndDepthASample) {
  camera_ = ReducedCamera();
  ColorImage color{80, 60, 3, {}};
  RawDepthImage raw{80, 60, 1, {}};
  for (int i = 0; i < 80 * 60; ++i) {
    const int x = i % 80, y = i / 80;
    const auto value = static_cast<std::uint8_t>(2 * x + 40 * (y % 2));
    color.pixels.insert(color.pixels.end(), {value, 7, 7});
    raw.pixels.push_back(static_cast<std::uint16_t>(x < 40 ? 10000 : 15000));
  }
  WritePng(folder_ / "c.png", color);
  WritePng(folder_ / "d.png", raw);
  const RgbdImages images = Rgbd();
  ASSERT_EQ(images.color.width, 40);
  ASSERT_EQ(images.depth.height, 30);
  for (int x = 0; x < 40; ++x) {
    EXPECT_EQ(images.color.At(x, 3, 0), 2 * (2 * x) + 1 + 20) << x;
    EXPECT_EQ(images.depth.At(x, 3), x < 20 ? 2.0f : 3.0f) << x;
  }
  WritePng(folder_ / "c.png", Constant<std::uint8_t>(1, 40, 30, 3));
  NIGHTMAP_EXPECT_ERROR(DataError, Color(), "c.png: 40 x 30 pixels, its camera has 80");
}

TEST_F(FramePixels, DepthAlongTheRayAndItsConfidenceAreOfTheStoredPicture) {
  camera_ = ReducedCamera();
  camera_.depth_along_ray = true;
  camera_.min_confidence = 1;
  GrayImage sure = Constant<std::uint8_t>(1);
  sure.At(5, 7) = 0;
  WritePng(folder_ / "d.png", TwoMetresAlongTheRay(camera_.Picture()));
  WritePng(folder_ / "sure.png", sure);
  frame_.others[kConfidenceChannel].path = "sure.png";
  const DepthImage depth = Depth();
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      if (x == 5 && y == 7) {
        EXPECT_EQ(depth.At(x, y), 0);
      } else {
        ASSERT_NEAR(depth.At(x, y), 2.0, 0.02) << x << " " << y;  // half a pixel of the ray
      }
    }
  }
}

TEST_F(FramePixels, AFrameWithoutDepthHasNoDepthPixels) {
  WritePng(folder_ / "c.png", Constant<std::uint8_t>(1, 40, 30, 3));
  frame_.depth.path = "";
  const RgbdImages images = Rgbd();
  EXPECT_EQ(images.color.pixels.size(), 3600u);
  EXPECT_EQ(images.depth.width, 0);
  EXPECT_TRUE(images.depth.pixels.empty());
  frame_.depth.path = "lost.png";
  NIGHTMAP_EXPECT_ERROR(DataError, Rgbd(), "lost.png");
}

TEST_F(FramePixels, TheCamerasMaskIsTakenOut) {
  ColorImage color = Constant<std::uint8_t>(90, 40, 30, 3);
  for (int x = 0; x < 40; ++x) color.At(x, 29, 1) = static_cast<std::uint8_t>(250 * (x % 2));
  WritePng(folder_ / "c.png", color);
  WritePng(folder_ / "d.png", Constant<std::uint16_t>(10000));
  camera_ = MaskedCamera();
  const RgbdImages images = Rgbd();
  EXPECT_EQ(images.moving.pixels, camera_.mask->pixels);
  for (int x = 0; x < 40; ++x) EXPECT_EQ(images.color.At(x, 29, 1), 90) << x;
  for (std::size_t i = 0; i < images.depth.pixels.size(); ++i) {
    ASSERT_EQ(images.depth.pixels[i] == 0, camera_.mask->pixels[i] != 0) << i;
  }
}

TEST_F(FramePixels, ImagesOfAnotherSizeAreRefused) {
  WritePng(folder_ / "d.png", Constant<std::uint16_t>(1000, 4, 4, 1));
  WritePng(folder_ / "c.png", Constant<std::uint8_t>(1, 4, 4, 3));
  NIGHTMAP_EXPECT_ERROR(DataError, Color(), "c.png: 4 x 4");
  NIGHTMAP_EXPECT_ERROR(DataError, Depth(), "d.png: 4 x 4");
  frame_.depth.path = "";
  NIGHTMAP_EXPECT_ERROR(DataError, Depth(), "no depth");
}

TEST_F(FramePixels, AnotherSizeIsRefusedBeforeAPixelIsDecoded) {
  // Headers without the pixels they announce.
  folder_.Write("c.ppm", "P6\n18000 18000\n255\nabc");
  folder_.Write("d.pgm", "P5\n30000 30000\n65535\nab");
  frame_.color.path = "c.ppm";
  frame_.depth.path = "d.pgm";
  NIGHTMAP_EXPECT_ERROR(DataError, Color(), "c.ppm: 18000 x 18000 pixels, its camera has 40 x 30");
  NIGHTMAP_EXPECT_ERROR(DataError, Depth(), "d.pgm: 30000 x 30000 pixels, its camera has 40 x 30");
  folder_.Write("c.ppm", "P6\n30000 30000\n255\nabc");  // more than any picture may have
  NIGHTMAP_EXPECT_ERROR(
      DataError, Color(), "c.ppm: header says 30000 x 30000 pixels of 3 channels");
}

TEST_F(FramePixels, ErrorsNameFilesAsTheListsDo) {
  folder_.Write("c.png", "");
  folder_.Write("d.png", "hello");
  for (const bool is_color : {true, false}) {
    try {
      is_color ? (void)Color() : (void)Depth();
      ADD_FAILURE() << "was read";
    } catch (const DataError& error) {
      EXPECT_THAT(error.what(), testing::StartsWith(is_color ? "c.png: " : "d.png: "));
      EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr(folder_.Path().string())));
    }
  }
}

TEST_F(FramePixels, ARealFrameLoadsAtFullSize) {
  NIGHTMAP_REQUIRE_DATA("tum_fr1_xyz_15hz");
  camera_.color.width = 640;
  camera_.color.height = 480;
  frame_.color.path = "rgb/1305031102.175304.jpg";
  frame_.depth.path = "depth/1305031102.160407.png";
  const auto root = TestDataPath("tum_fr1_xyz_15hz");
  EXPECT_EQ(LoadColor(frame_, camera_, root).pixels.size(), 640u * 480u * 3u);
  const DepthImage depth = LoadDepth(frame_, camera_, root);
  const auto num_measured =
      std::ranges::count_if(depth.pixels, [](float depth_m) { return depth_m > 0; });
  EXPECT_GT(num_measured, 640 * 480 / 2);
}

}  // namespace nightmap::frame_pixels_test
