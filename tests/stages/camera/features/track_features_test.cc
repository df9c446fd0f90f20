// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/features/track_features.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/random.h"
#include "pipeline/camera/extract_features.h"
#include "tests/test_data.h"

namespace nightmap::track_features_test {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// A smooth random pattern, rotated about the centre and shifted.
ColorImage MakeImage(double shift_px, double angle_rad, std::uint64_t seed = 1) {
  Random random(seed);
  struct Wave {
    double kx, ky, phase;
  };
  std::vector<Wave> waves;
  for (int i = 0; i < 60; ++i) {
    waves.push_back({random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), random.Uniform(0, 6.3)});
  }
  ColorImage image{kWidth, kHeight, 3, std::vector<std::uint8_t>(kWidth * kHeight * 3)};
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double u = x - kWidth / 2.0 - shift_px, v = y - kHeight / 2.0;
      double sum = 0;
      for (const Wave& wave : waves) {
        sum += std::sin(wave.kx * (c * u + s * v) + wave.ky * (c * v - s * u) + wave.phase);
      }
      const double gray = std::clamp(128 + 16 * sum, 0.0, 255.0);
      for (int k = 0; k < 3; ++k) image.At(x, y, k) = static_cast<std::uint8_t>(gray);
    }
  }
  return image;
}

class TrackFeaturesTest : public testing::Test {
 protected:
  TrackFeaturesTest() {
    camera_ = Camera{kWidth, kHeight, 300, 300, kWidth / 2.0, kHeight / 2.0};
    described_ = ExtractFeatures(MakeImage(0, 0), camera_, ExtractionOptions{});
    described_.frame_idx = 4;
  }
  FeatureTracker Started(const TrackingOptions& options = {}) const {
    FeatureTracker tracker(options);
    tracker.Start(MakeImage(0, 0), camera_, described_);
    return tracker;
  }
  Camera camera_;
  FrameFeatures described_;
};

TEST_F(TrackFeaturesTest, FollowsMotionToAFractionOfAPixel) {
  FeatureTracker tracker = Started();
  for (int i = 1; i <= 4; ++i) {
    const double shift_px = 3.3 * i, angle_rad = 0.01 * i;
    const auto tracked = tracker.Track(MakeImage(shift_px, angle_rad), camera_, 4 + i);
    ASSERT_TRUE(tracked);
    EXPECT_EQ(tracked->reference_frame_idx, 4);
    EXPECT_TRUE(tracked->descriptors.empty());
    ASSERT_EQ(tracked->reference_features.size(), tracked->raw_keypoints_px.size());
    std::vector<double> errors_px;
    for (std::size_t k = 0; k < tracked->raw_keypoints_px.size(); ++k) {
      const auto feature = static_cast<std::size_t>(tracked->reference_features[k]);
      const Eigen::Vector2d from = described_.raw_keypoints_px[feature].cast<double>() -
                                   Eigen::Vector2d(kWidth / 2.0, kHeight / 2.0);
      const Eigen::Vector2d expected = Eigen::Rotation2Dd(angle_rad) * from +
                                       Eigen::Vector2d(kWidth / 2.0 + shift_px, kHeight / 2.0);
      errors_px.push_back((tracked->raw_keypoints_px[k].cast<double>() - expected).norm());
    }
    std::ranges::sort(errors_px);
    EXPECT_LT(errors_px[errors_px.size() / 2], 0.1) << i;
    EXPECT_LT(errors_px[errors_px.size() * 9 / 10], 0.5) << i;
  }
}

TEST_F(TrackFeaturesTest, GivesUpWhereTheViewIsAnother) {
  FeatureTracker tracker = Started();
  EXPECT_FALSE(tracker.Track(MakeImage(0, 0, 2), camera_, 5));
  EXPECT_TRUE(tracker.Track(MakeImage(1, 0), camera_, 6));  // and is not confused by it
}

TEST_F(TrackFeaturesTest, GivesUpAfterSoManyFrames) {
  TrackingOptions options;
  options.max_gap_frames = 2;
  FeatureTracker tracker = Started(options);
  EXPECT_TRUE(tracker.Track(MakeImage(1, 0), camera_, 5));
  EXPECT_TRUE(tracker.Track(MakeImage(2, 0), camera_, 6));
  EXPECT_FALSE(tracker.Track(MakeImage(3, 0), camera_, 7));
  options.max_gap_frames = 0;
  EXPECT_FALSE(Started(options).Track(MakeImage(0, 0), camera_, 5));
  EXPECT_FALSE(FeatureTracker({}).Track(MakeImage(0, 0), camera_, 5));
}

TEST_F(TrackFeaturesTest, TracksTheStrongestFeaturesThatAreApart) {
  TrackingOptions options;
  options.max_tracked = 50;
  const auto tracked = Started(options).Track(MakeImage(0, 0), camera_, 5);
  ASSERT_TRUE(tracked);
  EXPECT_GT(tracked->NumFeatures(), 45);
  EXPECT_LE(tracked->NumFeatures(), 50);
  for (std::size_t i = 0; i < tracked->raw_keypoints_px.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      EXPECT_GT((tracked->raw_keypoints_px[i] - tracked->raw_keypoints_px[k]).norm(), 5);
    }
  }
}

}  // namespace nightmap::track_features_test
