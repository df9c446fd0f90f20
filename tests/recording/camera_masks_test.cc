// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/camera_masks.h"

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::camera_masks_test {

std::string CameraTable(const std::string& id) {
  return "[[camera]]\nid = \"" + id +
         "\"\nwidth = 8\nheight = 6\nfx = 7\nfy = 7\ncx = 3.5\ncy = 2.5\n"
         "depth_units_per_m = 1000\n";
}

const std::string kSite = "root = \"office\"\n" + CameraTable("high") + CameraTable("low") +
                          "mask = \"masks/low.png\"\n"
                          "[[sequence]]\nlayout = \"tum\"\nfolder = \".\"\ncamera = \"low\"\n";

class CameraMasksTest : public testing::Test {
 protected:
  CameraMasksTest() { std::filesystem::create_directories(folder_ / "office/masks"); }

  void Write(const Image<std::uint8_t>& picture) { WritePng(File(), picture); }
  std::filesystem::path File() const { return folder_ / "office/masks/low.png"; }
  void Expect(const std::string& why) {
    NIGHTMAP_EXPECT_ERROR(DataError,
                          ReadCameraMasks(folder_.Path(), &site_),
                          why,
                          "s.toml:11: mask = \"masks/low.png\"");
  }

  TemporaryFolder folder_;
  SiteConfig site_ = ParseSiteConfig(kSite, "s.toml");
};

// At 7 px per radian the corners are at 0.6 rad, at 2 px they are at 2.2: beyond what a pinhole
// holds.
TEST_F(CameraMasksTest, WhatAFisheyeHasNoRayForIsMasked) {
  Write({8, 6, 1, {255, 0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                   0,   0, 0, 0, 0,   0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}});
  for (RgbdCamera& camera : site_.cameras) camera.color.lens = Lens::kFisheye;
  site_.cameras[1].color.fx = site_.cameras[1].color.fy = 2;
  ReadCameraMasks(folder_.Path(), &site_);
  EXPECT_EQ(site_.cameras[0].mask, nullptr);
  const GrayImage& mask = *site_.cameras[1].mask;
  for (const auto& [x, y] : {std::pair{0, 0}, {7, 0}, {0, 5}, {7, 5}, {4, 0}}) {
    EXPECT_EQ(mask.At(x, y), 255) << x << ' ' << y;  // the last is the robot's
  }
  for (const auto& [x, y] : {std::pair{3, 2}, {4, 3}, {3, 0}, {5, 4}}) {
    EXPECT_EQ(mask.At(x, y), 0) << x << ' ' << y;
  }
}

TEST_F(CameraMasksTest, ALensThatSeesNoPixelIsRefused) {
  Write({8, 6, 1, {255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
                   0,   0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}});
  site_.cameras[0].color.lens = Lens::kFisheye;
  site_.cameras[0].color.cx = 30;
  NIGHTMAP_EXPECT_ERROR(DataError,
                        ReadCameraMasks(folder_.Path(), &site_),
                        "camera \"high\": its lens has no ray for any pixel");
}

// Gray or colored, and with the gray edges that drawing programs make.
TEST_F(CameraMasksTest, WhiteIsMasked) {
  for (const int num_channels : {1, 3}) {
    Image<std::uint8_t> picture{8, 6, num_channels, {}};
    for (int i = 0; i < 48; ++i) {
      const int level = i < 20 ? 0 : i < 24 ? 127 : i < 28 ? 128 : 255;
      picture.pixels.insert(picture.pixels.end(),
                            static_cast<std::size_t>(num_channels),
                            static_cast<std::uint8_t>(level));
    }
    Write(picture);
    ReadCameraMasks(folder_.Path(), &site_);
    EXPECT_EQ(site_.cameras[0].mask, nullptr);
    ASSERT_NE(site_.cameras[1].mask, nullptr);
    for (std::size_t i = 0; i < 48; ++i) {
      EXPECT_EQ(site_.cameras[1].mask->pixels[i], i < 24 ? 0 : 255) << i;
    }
  }
}

TEST_F(CameraMasksTest, AMaskHasTheSizeOfThePictureAndIsSeenAtThatOfColor) {
  RgbdCamera& camera = site_.cameras[1];
  ReduceToWorkingSize(12e-6, &camera);
  ASSERT_EQ(camera.color.width, 4);
  Image<std::uint8_t> picture{8, 6, 1, std::vector<std::uint8_t>(48, 0)};
  for (std::size_t i = 32; i < 48; ++i) picture.pixels[i] = 255;
  Write(picture);
  ReadCameraMasks(folder_.Path(), &site_);
  EXPECT_EQ(camera.mask->pixels,
            (std::vector<std::uint8_t>{0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255}));
  Write({4, 3, 1, std::vector<std::uint8_t>(12, 0)});
  Expect("low.png: 4 x 3 pixels, its camera has 8 x 6");
}

TEST_F(CameraMasksTest, WhatIsNoMaskOfTheCameraIsRefused) {
  Expect("low.png");  // missing
  folder_.Write("office/masks/low.png", "no picture");
  Expect("low.png");
  Write({6, 8, 1, std::vector<std::uint8_t>(48, 255)});
  Expect("low.png: 6 x 8 pixels, its camera has 8 x 6");
  Write({8, 6, 1, std::vector<std::uint8_t>(48, 1)});
  Expect("low.png: has no white pixel");
  Write({8, 6, 1, std::vector<std::uint8_t>(48, 255)});
  Expect("low.png: all of it is white");
}

}  // namespace nightmap::camera_masks_test
