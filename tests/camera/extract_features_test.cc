// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/extract_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "pipeline/base/random.h"
#include "pipeline/camera/descriptor_distance.h"
#include "tests/test_data.h"

namespace nightmap::extract_features_test {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr std::array kDetectors = {"sift", "orb", "brisk", "fast_orb", "fast_brisk", "harris"};
const Camera kCamera{kWidth, kHeight, 260, 260, 159.5, 119.5};

ExtractionOptions With(const std::string& detector, int num_features = 1000) {
  ExtractionOptions options;
  options.detector = detector;
  options.num_features = num_features;
  return options;
}

ColorImage Gray() {
  ColorImage image{kWidth, kHeight, 3, {}};
  image.pixels.assign(static_cast<std::size_t>(kWidth * kHeight * 3), 128);
  return image;
}

void AddDot(const Eigen::Vector2d& centre, double sigma_px, double height, ColorImage* image) {
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double squared = (Eigen::Vector2d(u, v) - centre).squaredNorm();
      const double add = height * std::exp(-squared / (2 * sigma_px * sigma_px));
      for (int c = 0; c < 3; ++c) {
        const double sum = std::clamp(image->At(u, v, c) + add, 0.0, 255.0);
        image->At(u, v, c) = static_cast<std::uint8_t>(std::lround(sum));
      }
    }
  }
}

// Soft dots of random place, size and gray, moved right by `shift_px`.
ColorImage Dots(int shift_px) {
  ColorImage image = Gray();
  Random random(3);
  for (int dot = 0; dot < 60; ++dot) {
    const double x = random.Uniform(40, 280) + shift_px, y = random.Uniform(30, 210);
    const double sigma_px = random.Uniform(2, 6), height = random.Uniform(-90, 90);
    AddDot({x, y}, sigma_px, height, &image);
  }
  return image;
}

// A mask over the strong dots, which leaves the faint ones of a wall.
TEST(ExtractFeatures, WeakOnesCountWhereAMaskLeavesFew) {
  ColorImage image = Gray();
  GrayImage moving{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight)};
  for (int y = 40; y < 220; y += 30) {
    for (int x = 30; x < 300; x += 30) AddDot({x, y}, 3, x < 160 ? 80 : 9, &image);
    for (int v = y - 15; v < y + 15; ++v) std::fill_n(&moving.At(0, v), 160, 255);
  }
  const auto num_right = [&](const GrayImage& mask) {
    const FrameFeatures features = ExtractFeatures(image, kCamera, {}, mask);
    return std::ranges::count_if(features.raw_keypoints_px,
                                 [](const auto& p) { return p.x() > 165; });
  };
  EXPECT_EQ(num_right({}), 0);
  EXPECT_GE(num_right(moving), 20);
}

TEST(ExtractFeatures, ABlankImageHasNone) {
  const ColorImage image = Gray();
  for (const char* detector : kDetectors) {
    EXPECT_EQ(ExtractFeatures(image, kCamera, With(detector)).NumFeatures(), 0) << detector;
  }
}

TEST(ExtractFeatures, EveryDetectorFillsEveryListAndRepeats) {
  const ColorImage image = Dots(0);
  for (const char* detector : kDetectors) {
    const ExtractionOptions options = With(detector, 50);
    const FrameFeatures features = ExtractFeatures(image, kCamera, options);
    const auto count = static_cast<std::size_t>(features.NumFeatures());
    EXPECT_GT(count, detector == std::string("harris") ? 1U : 10U) << detector;  // dots: no corners
    EXPECT_LE(count, 50U) << detector;
    EXPECT_EQ(features.raw_keypoints_px.size(), count);
    EXPECT_EQ(features.scales_px.size(), count);
    EXPECT_EQ(features.depths_m, std::vector<float>(count, 0));
    EXPECT_EQ(features.descriptors.size(),
              count * static_cast<std::size_t>(DescriptorSize(options.Kind())));
    EXPECT_EQ(ExtractFeatures(image, kCamera, options).descriptors, features.descriptors);
  }
}

TEST(ExtractFeatures, TheStrongestAreKeptInOrder) {
  const FrameFeatures all = ExtractFeatures(Dots(0), kCamera, {});
  const FrameFeatures few = ExtractFeatures(Dots(0), kCamera, With("sift", 50));
  ASSERT_EQ(few.NumFeatures(), 50);
  for (std::size_t i = 0; i < 50; ++i) EXPECT_EQ(few.keypoints_px[i], all.keypoints_px[i]);
}

// The same dot painted in each quarter of the image, ever fainter.
TEST(ExtractFeatures, FainterDotsComeLater) {
  const std::vector<Eigen::Vector2f> centers = {{240, 180}, {80, 60}, {240, 60}, {80, 180}};
  ColorImage image = Gray();
  for (std::size_t i = 0; i < centers.size(); ++i) {
    AddDot(centers[i].cast<double>(), 4, 120 - 25 * static_cast<double>(i), &image);
  }
  const FrameFeatures features = ExtractFeatures(image, kCamera, {});
  std::vector<std::size_t> order;  // of the first keypoints at the dots' centres
  for (const Eigen::Vector2f& p : features.keypoints_px) {
    for (std::size_t i = 0; i < centers.size(); ++i) {
      if ((p - centers[i]).norm() < 1 && std::ranges::count(order, i) == 0) order.push_back(i);
    }
  }
  EXPECT_EQ(order, (std::vector<std::size_t>{0, 1, 2, 3}));
}

// Kept few or many, the strongest keep their places: cv::ORB::compute alone would group by octave.
TEST(ExtractFeatures, OrbIsInOrderToo) {
  const ExtractionOptions options = With("orb", 50);
  const FrameFeatures few = ExtractFeatures(Dots(0), kCamera, options);
  std::set<float> scales(few.scales_px.begin(), few.scales_px.end());
  ASSERT_GT(scales.size(), 1U);
  EXPECT_FALSE(std::ranges::is_sorted(few.scales_px));

  // The descriptors moved with their keypoints: the same dot looks the same in a moved image.
  const FrameFeatures moved = ExtractFeatures(Dots(6), kCamera, options);
  std::vector<int> distances;
  for (std::size_t i = 0; i < few.keypoints_px.size(); ++i) {
    for (std::size_t k = 0; k < moved.keypoints_px.size(); ++k) {
      const Eigen::Vector2f step = moved.keypoints_px[k] - few.keypoints_px[i];
      if ((step - Eigen::Vector2f(6, 0)).norm() > 0.5F) continue;
      if (few.scales_px[i] != moved.scales_px[k]) continue;
      distances.push_back(DescriptorDistance(
          DescriptorKind::kOrb, &few.descriptors[32 * i], &moved.descriptors[32 * k]));
    }
  }
  ASSERT_GT(distances.size(), 10U);
  std::ranges::sort(distances);
  EXPECT_LT(distances[distances.size() / 2], 30);  // of 256 bits; 128 by chance
}

// FAST corners lie on whole pixels, so that an image moved by whole pixels has the very same ones,
// but for those whose surroundings reach over its edges.
TEST(ExtractFeatures, FastCornersAndTheirDescriptorsMoveWithTheImage) {
  for (const char* detector : {"fast_orb", "fast_brisk"}) {
    const ExtractionOptions options = With(detector);
    const FrameFeatures still = ExtractFeatures(Dots(0), kCamera, options);
    const FrameFeatures moved = ExtractFeatures(Dots(6), kCamera, options);
    ASSERT_GT(still.NumFeatures(), 20) << detector;
    const auto size = static_cast<std::size_t>(DescriptorSize(options.Kind()));
    constexpr float kEdge_px = 48;
    constexpr int kSame_bits = 16;  // of 256 and 512: sums over the image round otherwise
    int num_inside = 0, num_same = 0;
    for (std::size_t i = 0; i < still.keypoints_px.size(); ++i) {
      const Eigen::Vector2f& point = still.raw_keypoints_px[i];
      const Eigen::Vector2f size_px(kCamera.width, kCamera.height);
      if (point.minCoeff() < kEdge_px || (size_px - point).minCoeff() < kEdge_px + 6) continue;
      ++num_inside;
      for (std::size_t k = 0; k < moved.keypoints_px.size(); ++k) {
        const Eigen::Vector2f step = moved.raw_keypoints_px[k] - still.raw_keypoints_px[i];
        if (step != Eigen::Vector2f(6, 0)) continue;
        num_same += DescriptorDistance(options.Kind(),
                                       &still.descriptors[i * size],
                                       &moved.descriptors[k * size]) <= kSame_bits;
      }
    }
    ASSERT_GT(num_inside, 8) << detector;
    EXPECT_GE(num_same, 9 * num_inside / 10) << detector;
  }
}

TEST(ExtractFeatures, MoveWithTheImage) {
  const FrameFeatures a = ExtractFeatures(Dots(0), kCamera, {});
  const FrameFeatures b = ExtractFeatures(Dots(6), kCamera, {});
  int num_found = 0;
  for (const Eigen::Vector2f& p : a.keypoints_px) {
    num_found += std::ranges::any_of(b.keypoints_px, [&](const Eigen::Vector2f& q) {
      return (q - p - Eigen::Vector2f(6, 0)).norm() < 0.3F;
    });
  }
  EXPECT_GT(a.NumFeatures(), 30);
  EXPECT_GT(num_found, a.NumFeatures() * 8 / 10);
}

// Pixel (0, 0) is the centre of the first pixel, at every size of keypoint.
TEST(ExtractFeatures, SiftFindsDotsWhereTheyAre) {
  for (const double sigma_px : {1.5, 3.0, 6.0, 9.0}) {
    ColorImage image = Gray();
    Random random(7);
    std::vector<Eigen::Vector2f> centres;
    for (int dot = 0; dot < 6; ++dot) {
      const Eigen::Vector2d place(60 + 100 * (dot % 3), 60 + 120 * (dot / 3));
      const Eigen::Vector2d centre =
          place + Eigen::Vector2d(random.Uniform(0, 1), random.Uniform(0, 1));
      AddDot(centre, sigma_px, 90, &image);
      centres.push_back(centre.cast<float>());
    }
    const FrameFeatures features = ExtractFeatures(image, kCamera, {});
    for (const Eigen::Vector2f& centre : centres) {
      const auto off_px = [&](const Eigen::Vector2f& p) { return (p - centre).norm(); };
      EXPECT_LT(off_px(*std::ranges::min_element(features.keypoints_px, {}, off_px)), 0.1)
          << "sigma " << sigma_px << ", at " << centre.transpose();
    }
  }
}

TEST(ExtractFeatures, DistortionIsTakenOutOfTheKeypointsOnly) {
  Camera distorted = kCamera;
  distorted.k1 = -0.2;
  distorted.p1 = 0.003;
  const FrameFeatures plain = ExtractFeatures(Dots(0), kCamera, {});
  const FrameFeatures features = ExtractFeatures(Dots(0), distorted, {});
  ASSERT_EQ(features.NumFeatures(), plain.NumFeatures());
  for (std::size_t i = 0; i < features.keypoints_px.size(); ++i) {
    EXPECT_EQ(features.raw_keypoints_px[i], plain.raw_keypoints_px[i]);
    const Eigen::Vector2d raw = features.raw_keypoints_px[i].cast<double>();
    EXPECT_LT((features.keypoints_px[i].cast<double>() - distorted.Undistort(raw)).norm(), 1e-3);
  }
}

}  // namespace nightmap::extract_features_test
