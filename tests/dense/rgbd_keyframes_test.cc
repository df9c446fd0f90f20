// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/rgbd_keyframes.h"

#include <opencv2/imgproc.hpp>
#include <vector>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::rgbd_keyframes_test {

constexpr int kNumKeyframes = 40;

KeyframeSource Source() {
  KeyframeSource source;
  source.cameras.resize(1);
  for (int i = 0; i < kNumKeyframes; ++i) {
    Keyframe keyframe;
    keyframe.keyframe_idx = i;
    keyframe.frame.color.path = std::to_string(i) + ".png";
    source.keyframes.push_back(keyframe);
  }
  source.load = [](const Keyframe& keyframe) -> RgbdImages {
    if (keyframe.keyframe_idx == 7) throw DataError("7.png: truncated");
    return {{}, {1, 1, 1, {static_cast<float>(keyframe.keyframe_idx)}}};
  };
  return source;
}

struct Fused {
  std::vector<float> merged;
  std::vector<std::string> skipped;
};

Fused Fuse(int num_threads) {
  Progress progress("test", false);
  Fused fused;
  fused.skipped = FuseKeyframes<float>(
      Source(),
      progress,
      num_threads,
      [](const Keyframe& keyframe, const RgbdImages& images) {
        if (keyframe.keyframe_idx == 9) cv::resize(cv::Mat(), cv::noArray(), {10, 10});
        if (keyframe.keyframe_idx == 30) std::vector<double>(std::size_t{1} << 62).front() = 1;
        return images.depth.pixels[0];
      },
      [&](float value) { fused.merged.push_back(value); });
  return fused;
}

TEST(FuseKeyframes, AFailureIsOfItsKeyframeAlone) {
  const Fused fused = Fuse(1);
  std::vector<float> expected;
  for (int i = 0; i < kNumKeyframes; ++i) {
    if (i != 7 && i != 9 && i != 30) expected.push_back(static_cast<float>(i));
  }
  EXPECT_EQ(fused.merged, expected);
  ASSERT_EQ(fused.skipped.size(), 3U);
  EXPECT_EQ(fused.skipped[0], "7.png: truncated");
  EXPECT_THAT(fused.skipped[1], testing::StartsWith("9.png: OpenCV: "));
  EXPECT_THAT(fused.skipped[2], testing::StartsWith("30.png: needs more than any memory"));
  const Fused by_four = Fuse(4);
  EXPECT_EQ(by_four.merged, fused.merged);
  EXPECT_EQ(by_four.skipped, fused.skipped);
}

}  // namespace nightmap::rgbd_keyframes_test
