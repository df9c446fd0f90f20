// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/mirror_features.h"

#include "tests/stages/camera/localize/rendered_map.h"
#include "tests/test_data.h"

namespace nightmap::mirror_features_test {

constexpr DescriptorKind kKind = DescriptorKind::kRootSift;

ColorImage Flipped(const ColorImage& picture) {
  ColorImage flipped = picture;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      for (int c = 0; c < 3; ++c) flipped.At(x, y, c) = picture.At(picture.width - 1 - x, y, c);
    }
  }
  return flipped;
}

// Share of the features of `a` that `b` has at the same pixel with nearly the same descriptor.
double SameRatio(const FrameFeatures& a, const FrameFeatures& b) {
  const int max_distance = DistanceFromRelative(kKind, 0.2);
  int num_same = 0;
  for (int i = 0; i < a.NumFeatures(); ++i) {
    bool is_same = false;
    for (int k = 0; k < b.NumFeatures(); ++k) {
      const double apart_px = (a.Feature(i).Pixel() - b.Feature(k).Pixel()).norm();
      is_same |= apart_px < 1 && DescriptorDistance(kKind,
                                                    a.Feature(i).Descriptor(kKind),
                                                    b.Feature(k).Descriptor(kKind)) < max_distance;
    }
    num_same += is_same;
  }
  return static_cast<double>(num_same) / a.NumFeatures();
}

class MirrorFeaturesTest : public testing::Test {
 protected:
  const Camera camera_{320, 240, 262.5, 262.5, 159.5, 119.5};
  const ColorImage picture_ = Render(PosterWorld(), camera_, PosterPose(2.4), {}, 2.0, 7).color;
  const FrameFeatures features_ = ExtractFeatures(picture_, camera_, {});
};

TEST_F(MirrorFeaturesTest, AreThoseOfTheMirroredPicture) {
  const auto mirrored = MirrorFeatures(features_, kKind, camera_);
  const auto of_flipped = ExtractFeatures(Flipped(picture_), camera_, {});
  ASSERT_TRUE(mirrored);
  EXPECT_GT(SameRatio(*mirrored, of_flipped), 0.9);
  FrameFeatures unturned = *mirrored;
  unturned.descriptors = features_.descriptors;
  EXPECT_LT(SameRatio(unturned, of_flipped), 0.1);
}

TEST_F(MirrorFeaturesTest, TwiceMirroredIsTheSame) {
  const Camera off_middle{320, 240, 262.5, 262.5, 140, 119.5};
  const auto once = MirrorFeatures(features_, kKind, off_middle);
  const auto twice = MirrorFeatures(*once, kKind, off_middle);
  EXPECT_EQ(twice->descriptors, features_.descriptors);
  for (int i = 0; i < features_.NumFeatures(); ++i) {
    EXPECT_NEAR((twice->Feature(i).Pixel() - features_.Feature(i).Pixel()).norm(), 0, 1e-3);
    EXPECT_NEAR(once->Feature(i).Pixel().x() - 140, 140 - features_.Feature(i).Pixel().x(), 1e-3);
  }
}

TEST_F(MirrorFeaturesTest, OtherDescriptorsCannotBeMirrored) {
  EXPECT_FALSE(MirrorFeatures({}, DescriptorKind::kOrb, camera_));
  EXPECT_FALSE(MirrorFeatures({}, DescriptorKind::kBrisk, camera_));
}

}  // namespace nightmap::mirror_features_test
