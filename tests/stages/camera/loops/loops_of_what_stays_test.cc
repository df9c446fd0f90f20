// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/loops/loops_of_what_stays.h"

#include "pipeline/io/masks_io.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::loops_of_what_stays_test {

// A way that is gone twice, with a mask of the upper half of each picture of the first time.
TEST(RunLoopsOfWhatStays, PairsHaveNoMaskedFeatureAndTheIndicesOfTheInput) {
  LandmarkScene scene = MakeLandmarkScene();
  const std::size_t num_out = scene.frames.size();
  GoAgain(&scene);
  const Camera& camera = scene.cameras[0].color;
  GrayImage upper{camera.width, camera.height, 1, {}};
  upper.pixels.resize(static_cast<std::size_t>(camera.width) *
                      static_cast<std::size_t>(camera.height));
  std::fill_n(upper.pixels.begin(), upper.pixels.size() / 2, std::uint8_t{255});
  std::vector<PackedMask> masks;
  for (std::size_t i = 0; i < num_out; ++i) {
    masks.push_back(PackMask(scene.frames[i].time_ns, upper));
    scene.frames[i].others[kMaskChannel] = {"masks.h5", HashOf(masks.back())};
  }
  const TemporaryFolder folder;
  const auto path = folder.Path() / "masks.h5";
  WriteMasks(path, masks, "");

  LoopsOptions options;
  options.min_gap = 8;
  options.verify.pose.min_inliers = 12;
  const Vocabulary vocabulary = MakeSceneVocabulary(scene);
  const auto pairs = RunLoopsOfWhatStays(
      options, scene.Input(), vocabulary, scene.frames, FrameReader({}, {path}), NoProgress(), 2);
  int num_exact = 0;
  for (const FramePair& pair : pairs) {
    const FrameFeatures& a = scene.features.frames[static_cast<std::size_t>(pair.frame_a)];
    for (const FeatureMatch& match : pair.inliers) {
      const float y = a.raw_keypoints_px[static_cast<std::size_t>(match.a)].y();
      const bool is_masked =
          std::cmp_less(pair.frame_a, num_out) && std::lround(y) < upper.height / 2;
      EXPECT_FALSE(is_masked) << pair.frame_a << ": " << y;
      EXPECT_TRUE(pair.frame_b - pair.frame_a != 8 || match.a == match.b);
    }
    num_exact += pair.frame_b - pair.frame_a == 8 && pair.status == PairStatus::kAccepted;
  }
  EXPECT_GT(num_exact, 0);
}

}  // namespace nightmap::loops_of_what_stays_test
