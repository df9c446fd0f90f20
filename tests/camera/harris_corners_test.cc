// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/harris_corners.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "pipeline/base/random.h"
#include "pipeline/camera/descriptor_distance.h"
#include "pipeline/camera/extract_features.h"
#include "tests/test_data.h"

namespace nightmap::harris_corners_test {

constexpr int kWidth = 320, kHeight = 240;
const Eigen::Vector2d kCentre(160.3, 119.6);
const Camera kCamera{kWidth, kHeight, 250, 250, 159.5, 119.5};

double Radians(double angle_deg) { return angle_deg * std::numbers::pi / 180; }

// A picture of what is at a point, turned about kCentre; a pixel is the mean of 10 x 10 points.
GrayImage Render(double angle_deg, const std::function<double(const Eigen::Vector2d&)>& gray_at) {
  GrayImage image{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight)};
  const Eigen::Rotation2Dd back(-Radians(angle_deg));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      double sum = 0;
      for (int k = 0; k < 100; ++k) {
        const Eigen::Vector2d pixel(x + (k % 10) / 10.0 - 0.45, y + (k / 10) / 10.0 - 0.45);
        sum += gray_at(back * (pixel - kCentre));
      }
      image.At(x, y) = static_cast<std::uint8_t>(std::lround(sum / 100));
    }
  }
  return image;
}

// Tiles of random gray.
GrayImage Tiles(double angle_deg, double size_px = 23) {
  Random random(5);
  std::vector<double> grays;
  for (int i = 0; i < 64 * 64; ++i) grays.push_back(random.Uniform(20, 235));
  return Render(angle_deg, [&](const Eigen::Vector2d& point) {
    const int column = static_cast<int>(std::floor(point.x() / size_px)) + 32;
    const int row = static_cast<int>(std::floor(point.y() / size_px)) + 32;
    return grays[static_cast<std::size_t>(std::clamp(row, 0, 63) * 64 + std::clamp(column, 0, 63))];
  });
}

ColorImage ToColor(const GrayImage& gray) {
  ColorImage color{gray.width, gray.height, 3, {}};
  for (const std::uint8_t value : gray.pixels) color.pixels.insert(color.pixels.end(), 3, value);
  return color;
}

TEST(HarrisCorners, AreOnTheCornersOfACheckerboardAtAnyAngle) {
  constexpr double kSquare_px = 24;
  for (const double angle_deg : {0.0, 11.0, 37.0, 45.0, 90.0, 128.5}) {
    const GrayImage image = Render(angle_deg, [](const Eigen::Vector2d& point) {
      const double sum = std::floor(point.x() / kSquare_px) + std::floor(point.y() / kSquare_px);
      return std::fmod(std::abs(sum), 2) < 0.5 ? 60.0 : 190.0;
    });
    const auto corners = FindHarrisCorners(image, {});
    EXPECT_GT(corners.size(), 60U) << angle_deg;
    const Eigen::Rotation2Dd back(-Radians(angle_deg));
    for (const HarrisCorner& corner : corners) {
      const Eigen::Vector2d point = back * (corner.pixel.cast<double>() - kCentre);
      const Eigen::Vector2d off =
          point - kSquare_px * (point / kSquare_px).array().round().matrix();
      EXPECT_LE(off.norm(), 0.1) << angle_deg << " at " << corner.pixel.transpose();
    }
  }
}

TEST(HarrisCorners, TheirDescriptorsTurnWithThePicture) {
  ExtractionOptions options;
  options.detector = "harris";
  options.num_features = 300;
  const FrameFeatures still = ExtractFeatures(ToColor(Tiles(0, 9)), kCamera, options);
  const FrameFeatures turned = ExtractFeatures(ToColor(Tiles(37, 9)), kCamera, options);
  ASSERT_GT(still.NumFeatures(), 100);
  std::vector<int> distances, of_others;
  for (std::size_t i = 0; i < still.keypoints_px.size(); ++i) {
    const Eigen::Vector2d offset = still.raw_keypoints_px[i].cast<double>() - kCentre;
    const Eigen::Vector2d expected = Eigen::Rotation2Dd(Radians(37)) * offset + kCentre;
    for (std::size_t k = 0; k < turned.keypoints_px.size(); ++k) {
      const double off_px = (turned.raw_keypoints_px[k].cast<double>() - expected).norm();
      (off_px < 0.5 ? distances : of_others)
          .push_back(DescriptorDistance(
              DescriptorKind::kOrb, &still.descriptors[32 * i], &turned.descriptors[32 * k]));
    }
  }
  ASSERT_GT(distances.size(), 40U);
  std::ranges::sort(distances);
  std::ranges::sort(of_others);
  EXPECT_LE(distances[distances.size() / 2], 24);  // of 256 bits; 128 by chance
  EXPECT_LT(distances[9 * distances.size() / 10], of_others[of_others.size() / 100]);
}

TEST(HarrisCorners, OneStrongThingDoesNotTakeAll) {
  GrayImage image = Tiles(0);
  for (std::uint8_t& value : image.pixels) value = static_cast<std::uint8_t>(110 + value / 12);
  for (int y = 81; y < 117; ++y) {  // a grille in one cell, and little contrast elsewhere
    for (int x = 121; x < 157; ++x) image.At(x, y) = (x / 9 + y / 9) % 2 == 0 ? 0 : 255;
  }
  const auto num_in_grille = [&](int max_per_cell) {
    const auto corners =
        FindHarrisCorners(image, {.min_gradient = 1, .max_per_cell = max_per_cell});
    EXPECT_GT(corners.size(), 60U);
    return std::ranges::count_if(corners, [](const HarrisCorner& corner) {
      return (corner.pixel - Eigen::Vector2f(139, 99)).cwiseAbs().maxCoeff() < 17;
    });
  };
  EXPECT_GE(num_in_grille(1000), 8);
  EXPECT_LE(num_in_grille(4), 4);
  EXPECT_GE(num_in_grille(4), 2);
}

TEST(HarrisCorners, RepeatAndAreInOrder) {
  const GrayImage image = Tiles(20);
  const auto corners = FindHarrisCorners(image, {}), again = FindHarrisCorners(image, {});
  ASSERT_EQ(corners.size(), again.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    EXPECT_EQ(corners[i].pixel, again[i].pixel);
    EXPECT_EQ(corners[i].angle_deg, again[i].angle_deg);
  }
  EXPECT_TRUE(std::ranges::is_sorted(corners, std::greater(), &HarrisCorner::response));
}

TEST(HarrisCorners, SaturatedAndTinyPicturesHaveNone) {
  const GrayImage white{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight, 255)};
  EXPECT_TRUE(FindHarrisCorners(white, {}).empty());
  const GrayImage tiny{12, 9, 1, std::vector<std::uint8_t>(108, 3)};
  EXPECT_TRUE(FindHarrisCorners(tiny, {}).empty());
  EXPECT_TRUE(FindHarrisCorners({}, {}).empty());
}

}  // namespace nightmap::harris_corners_test
