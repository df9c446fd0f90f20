// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/survey/fixed_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "pipeline/base/random.h"

namespace nightmap::fixed_parts_test {

constexpr int kWidth = 160, kHeight = 120;
constexpr int kNumViews = 40;

using Pixels = std::function<bool(int x, int y)>;

// A wall with boards of all grays, of which a view is a part.
class World {
 public:
  World() : wall_(700, 900, CV_8UC1, cv::Scalar(120)) {
    Random random(3);
    for (int i = 0; i < 1500; ++i) {
      const cv::Rect board(static_cast<int>(random.Uniform(0, wall_.cols)),
                           static_cast<int>(random.Uniform(0, wall_.rows)),
                           static_cast<int>(random.Uniform(8, 40)),
                           static_cast<int>(random.Uniform(8, 40)));
      cv::rectangle(wall_, board, cv::Scalar(random.Uniform(10, 240)), cv::FILLED);
    }
  }

  // The camera's view at the i-th place.
  GrayImage View(int i) const {
    const cv::Mat part =
        wall_(
            {(i * 97) % (wall_.cols - kWidth), (i * 61) % (wall_.rows - kHeight), kWidth, kHeight})
            .clone();
    return {kWidth, kHeight, 1, {part.begin<std::uint8_t>(), part.end<std::uint8_t>()}};
  }

 private:
  cv::Mat wall_;
};

std::vector<GrayImage> Views(int count) {
  const World world;
  std::vector<GrayImage> views;
  for (int i = 0; i < count; ++i) views.push_back(world.View(i));
  return views;
}

// Draws gray(x, y) where the part is, with the noise of a sensor, and in light that changes.
void DrawPart(const Pixels& is_part,
              const std::function<double(int x, int y)>& gray,
              double light_change,
              std::vector<GrayImage>* views) {
  Random random(5);
  for (std::size_t i = 0; i < views->size(); ++i) {
    const double light = 1 - light_change * static_cast<double>(i % 5) / 4;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double level = gray(x, y) * light + random.Uniform(-3, 3);
        if (is_part(x, y)) {
          (*views)[i].At(x, y) = static_cast<std::uint8_t>(std::clamp(level, 0.0, 255.0));
        }
      }
    }
  }
}

bool IsPlate(int /*x*/, int y) { return y >= 98; }
bool IsArm(int x, int y) { return x < 24 && y > 30; }
bool IsBlob(int x, int y) { return (x - 80) * (x - 80) + (y - 120) * (y - 120) < 38 * 38; }
double Texture(int x, int y) {
  const std::uint32_t cell = static_cast<std::uint32_t>(x / 5 * 7919 + y / 4 * 104729);
  return 30 + static_cast<double>(cell * 2654435761U % 200);
}
double Dark(int /*x*/, int /*y*/) { return 22; }
// Neither darker nor brighter than most of the world.
double MidGray(int /*x*/, int /*y*/) { return 150; }

// Share of the picture that is masked and no part, or a part and not masked.
double ShareWrong(const FixedParts& parts, const Pixels& is_part) {
  if (parts.mask.pixels.empty()) return 1;
  int num_wrong = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      num_wrong += (parts.mask.At(x, y) != 0) != is_part(x, y) ? 1 : 0;
    }
  }
  return static_cast<double>(num_wrong) / (kWidth * kHeight);
}

TEST(FixedParts, AreFoundWhateverTheyLookLike) {
  for (const Pixels& is_part : {Pixels(IsPlate), Pixels(IsArm), Pixels(IsBlob)}) {
    for (const auto gray : {Texture, Dark, MidGray}) {
      auto views = Views(kNumViews);
      DrawPart(is_part, gray, 0, &views);
      const FixedParts parts = FindFixedParts(views);
      EXPECT_EQ(parts.num_views, views.size());
      EXPECT_LT(ShareWrong(parts, is_part), 0.02) << "gray " << gray(80, 110);
    }
  }
}

TEST(FixedParts, TextureIsFoundInLightThatChanges) {
  auto views = Views(kNumViews);
  DrawPart(IsPlate, Texture, 0.5, &views);
  EXPECT_LT(ShareWrong(FindFixedParts(views), IsPlate), 0.02);
}

TEST(FixedParts, AMovingCameraThatSeesOnlyTheWorldHasNone) {
  EXPECT_TRUE(FindFixedParts(Views(kNumViews)).mask.pixels.empty());
}

// A ceiling ends elsewhere in each picture.
TEST(FixedParts, WhatIsEvenWithoutAnEdgeThatStaysIsTheWorld) {
  auto views = Views(kNumViews);
  Random random(6);
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (int x = 0; x < kWidth; ++x) {
      for (int y = 0; y < 25 + 7 * static_cast<int>(i % 7) + x / 16; ++y) {
        views[i].At(x, y) = static_cast<std::uint8_t>(235 + random.Uniform(-3, 3));
      }
    }
  }
  EXPECT_TRUE(FindFixedParts(views).mask.pixels.empty());
}

TEST(FixedParts, ACameraAtRestShowsOneView) {
  auto pictures = Views(kNumViews);
  pictures.resize(400, World().View(0));
  Random random(7);
  for (GrayImage& picture : pictures) {
    for (std::uint8_t& level : picture.pixels) {
      level = static_cast<std::uint8_t>(std::clamp(level + random.Uniform(-4, 4), 0.0, 255.0));
    }
  }
  const FixedParts parts = FindFixedParts(pictures);
  EXPECT_EQ(parts.num_views, static_cast<std::size_t>(kNumViews));
  EXPECT_TRUE(parts.mask.pixels.empty());
}

TEST(FixedParts, FewViewsTellNothing) {
  auto views = Views(static_cast<int>(kMinViews) - 1);
  DrawPart(IsPlate, Texture, 0, &views);
  EXPECT_TRUE(FindFixedParts(views).mask.pixels.empty());
  EXPECT_TRUE(FindFixedParts({}).mask.pixels.empty());
}

TEST(FixedParts, MostOfThePictureIsNoPartOfTheRobot) {
  auto views = Views(kNumViews);
  DrawPart([](int, int y) { return y > 40; }, Texture, 0, &views);
  EXPECT_TRUE(FindFixedParts(views).mask.pixels.empty());
}

TEST(EnlargeMask, HasTheSizeOfThePicturesAndAMargin) {
  GrayImage mask{16, 12, 1, std::vector<std::uint8_t>(16 * 12, 0)};
  mask.At(8, 6) = 255;
  const GrayImage enlarged = EnlargeMask(mask, 64, 48, 1);
  EXPECT_EQ(enlarged.width, 64);
  EXPECT_EQ(enlarged.height, 48);
  EXPECT_EQ(std::ranges::count(enlarged.pixels, 255), 5 * 16);
  EXPECT_EQ(enlarged.At(33, 25), 255);
  EXPECT_EQ(enlarged.At(29, 25), 255);
  EXPECT_EQ(enlarged.At(27, 25), 0);
}

}  // namespace nightmap::fixed_parts_test
