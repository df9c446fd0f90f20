// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/leave_out.h"

#include "pipeline/base/input_error.h"
#include "pipeline/io/masks_io.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::leave_out_test {

// The scene's frames, of which the first has a mask of the left half of its picture.
class LeaveOutTest : public testing::Test {
 protected:
  LeaveOutTest() {
    const Camera& camera = scene_.cameras[0].color;
    GrayImage left{camera.width, camera.height, 1, {}};
    for (int i = 0; i < camera.width * camera.height; ++i) {
      left.pixels.push_back(i % camera.width < camera.width / 2 ? 255 : 0);
    }
    const PackedMask mask = PackMask(scene_.frames[0].time_ns, left);
    WriteMasks(path_, {mask}, "");
    scene_.frames[0].others[kMaskChannel] = {"masks.h5", HashOf(mask)};
  }

  LandmarkScene scene_ = MakeLandmarkScene();
  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.Path() / "masks.h5";
};

TEST_F(LeaveOutTest, MaskedFeaturesAreGoneAndTheOthersAsBefore) {
  const FeaturesShard& before = scene_.features;
  const SiteFeatures features(before);
  const IndicesBefore indices =
      UnmaskedFeatures(scene_.frames, scene_.cameras, FrameReader({}, {path_}), features);
  const FeaturesShard after = KeepFeatures(features, indices).All();
  ASSERT_TRUE(indices[0]);
  const FrameFeatures& all = before.frames[0];
  const FrameFeatures& kept = after.frames[0];
  const auto size = static_cast<std::size_t>(before.descriptor_size);
  const float middle_px = static_cast<float>(scene_.cameras[0].color.width) / 2;
  std::size_t next = 0;
  for (std::size_t i = 0; i < all.keypoints_px.size(); ++i) {
    if (std::lround(all.raw_keypoints_px[i].x()) < std::lround(middle_px)) continue;
    ASSERT_LT(next, kept.keypoints_px.size());
    EXPECT_EQ((*indices[0])[next], static_cast<int>(i));
    EXPECT_EQ(kept.keypoints_px[next], all.keypoints_px[i]);
    EXPECT_EQ(kept.depths_m[next], all.depths_m[i]);
    EXPECT_TRUE(
        std::equal(kept.descriptors.begin() + static_cast<std::ptrdiff_t>(next * size),
                   kept.descriptors.begin() + static_cast<std::ptrdiff_t>((next + 1) * size),
                   all.descriptors.begin() + static_cast<std::ptrdiff_t>(i * size)));
    ++next;
  }
  EXPECT_EQ(next, kept.keypoints_px.size());
  EXPECT_LT(next, all.keypoints_px.size());
  EXPECT_GT(next, 0U);
  for (std::size_t i = 1; i < before.frames.size(); ++i) {
    EXPECT_EQ(after.frames[i], before.frames[i]);
    EXPECT_FALSE(indices[i]);
  }
}

TEST_F(LeaveOutTest, WithoutFilesOfMasksNothingIsLeftOut) {
  for (const auto& left : UnmaskedFeatures(
           scene_.frames, scene_.cameras, FrameReader({}), SiteFeatures(scene_.features))) {
    EXPECT_FALSE(left);
  }
}

TEST_F(LeaveOutTest, AListOfOtherFramesIsRefused) {
  scene_.frames.pop_back();
  EXPECT_THROW(UnmaskedFeatures(
                   scene_.frames, scene_.cameras, FrameReader({}), SiteFeatures(scene_.features)),
               InputError);
}

}  // namespace nightmap::leave_out_test
