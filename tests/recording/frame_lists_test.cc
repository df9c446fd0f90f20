// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/frame_lists.h"

#include <gtest/gtest.h>

namespace nightmap::frame_lists_test {

TEST(KeepUsedCameras, OnesThatNoFrameHasAreLeftOut) {
  std::vector<RgbdCamera> cameras(5);
  for (std::size_t i = 0; i < cameras.size(); ++i) cameras[i].camera_id = std::to_string(i);
  std::vector<FrameRecord> frames(4);
  frames[0].camera_idx = 4;
  frames[1].camera_idx = 1;
  frames[2].camera_idx = 4;
  frames[3].camera_idx = 3;
  const auto kept = KeepUsedCameras(cameras, &frames);
  ASSERT_EQ(kept.size(), 3u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto& id = kept.at(static_cast<std::size_t>(frames[i].camera_idx)).camera_id;
    EXPECT_EQ(id, (std::vector<std::string>{"4", "1", "4", "3"}[i]));
  }
  // A camera more, before or after those in use, changes nothing.
  cameras.insert(cameras.begin(), RgbdCamera{});
  cameras.emplace_back();
  auto moved = frames;
  moved[0].camera_idx = moved[2].camera_idx = 5;
  moved[1].camera_idx = 2;
  moved[3].camera_idx = 4;
  EXPECT_EQ(CamerasToJson(KeepUsedCameras(cameras, &moved)), CamerasToJson(kept));
  EXPECT_EQ(FramesToCsv(moved), FramesToCsv(frames));
  std::vector<FrameRecord> none;
  EXPECT_TRUE(KeepUsedCameras(cameras, &none).empty());
}

}  // namespace nightmap::frame_lists_test
