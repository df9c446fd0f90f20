// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/ghosts/ghosts.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"

namespace nightmap::ghosts_test {

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr float kWall_m = 3;
constexpr float kPerson_m = 2;

// A camera moves to the right along a wall, before which somebody may stand.
class GhostsTest : public testing::Test {
 protected:
  GhostsTest() {
    RgbdCamera camera;
    camera.color = Camera{kWidth, kHeight, 130, 130, 79.5, 59.5};
    input_.cameras = {camera};
    for (int i = 0; i < 8; ++i) {
      Keyframe keyframe;
      keyframe.keyframe_idx = i;
      keyframe.frame.frame_idx = i;
      keyframe.frame.time_ns = 1'000'000'000LL * i;
      keyframe.frame.color = {"color/" + std::to_string(i), "h"};
      keyframe.map_from_camera.translation.x() = 0.1 * i;
      input_.keyframes.push_back(keyframe);
    }
    input_.depth = [this](const Keyframe& keyframe) {
      DepthImage depth{kWidth, kHeight, 1, std::vector<float>(kWidth * kHeight, kWall_m)};
      ForPerson(keyframe, [&](int x, int y) { depth.At(x, y) = kPerson_m; });
      if (in_front_m_ > 0 && !IsThere(keyframe))
        depth.pixels.assign(depth.pixels.size(), in_front_m_);
      return depth;
    };
    input_.moving = [](const Keyframe&) {
      return GrayImage{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight)};
    };
    input_.may_move = [this](const Keyframe& keyframe) {
      GrayImage may_move{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight)};
      ForPerson(keyframe, [&](int x, int y) { may_move.At(x, y) = 255; });
      return may_move;
    };
  }

  bool IsThere(const Keyframe& keyframe) const { return keyframe.keyframe_idx < leaves_at_; }

  template <typename Use>
  void ForPerson(const Keyframe& keyframe, const Use& use) const {
    if (!IsThere(keyframe)) return;
    for (int y = 20; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double at_m = (x - 79.5) / 130 * kPerson_m + keyframe.map_from_camera.translation.x();
        if (at_m > 0 && at_m < 0.6) use(x, y);
      }
    }
  }

  GhostsResult Run(int num_threads = 2, int min_keyframes = 2) const {
    GhostsOptions options;
    options.min_keyframes = min_keyframes;
    Progress progress("ghosts", false);
    return RunGhosts(options, input_, progress, num_threads);
  }

  GhostsInput input_;
  int leaves_at_ = 4;
  float in_front_m_ = 0;
};

TEST_F(GhostsTest, WhoLeavesIsMaskedWhereHeStood) {
  const GhostsResult result = Run();
  EXPECT_EQ(result.num_regions, 4);
  EXPECT_EQ(result.num_ghosts, 4);
  for (const Keyframe& keyframe : input_.keyframes) {
    const auto k = static_cast<std::size_t>(keyframe.keyframe_idx);
    ASSERT_TRUE(result.masks[k]);
    EXPECT_EQ(UnpackMask(*result.masks[k]).pixels, input_.may_move(keyframe).pixels) << k;
  }
}

TEST_F(GhostsTest, WhoStaysIsNotMasked) {
  leaves_at_ = 8;
  const GhostsResult result = Run();
  EXPECT_EQ(result.num_regions, 8);
  EXPECT_EQ(result.num_ghosts, 0);
  for (const auto& mask : result.masks) EXPECT_EQ(NumMasked(*mask), 0U);
}

TEST_F(GhostsTest, AHiddenPlaceSaysNothing) {
  in_front_m_ = 1;
  EXPECT_EQ(Run().num_ghosts, 0);
}

TEST_F(GhostsTest, OneKeyframeIsNotEnough) {
  leaves_at_ = 7;
  EXPECT_EQ(Run().num_ghosts, 0);
  EXPECT_GT(Run(2, 1).num_ghosts, 0);
}

TEST_F(GhostsTest, WhatMovesIsMaskedToo) {
  leaves_at_ = 0;
  input_.moving = [](const Keyframe&) {
    GrayImage moving{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight)};
    moving.At(3, 5) = 255;
    return moving;
  };
  for (const auto& mask : Run().masks) EXPECT_EQ(UnpackMask(*mask).At(3, 5), 255);
}

TEST_F(GhostsTest, AKeyframeThatCannotBeReadIsSkipped) {
  input_.moving = [](const Keyframe& keyframe) {
    if (keyframe.keyframe_idx == 5) return GrayImage{};
    return GrayImage{kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight)};
  };
  const auto depth = input_.depth;
  input_.depth = [depth](const Keyframe& keyframe) {
    if (keyframe.keyframe_idx == 6) throw DataError("depth/6: truncated");
    return depth(keyframe);
  };
  const GhostsResult result = Run();
  EXPECT_EQ(result.skipped, std::vector<std::string>{"depth/6: truncated"});
  for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(result.masks[k].has_value(), k != 5 && k != 6);
  EXPECT_EQ(result.num_ghosts, 4);
}

TEST_F(GhostsTest, IsTheSameAtAnyNumberOfThreads) {
  const GhostsResult one = Run(1), four = Run(4);
  for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(one.masks[k]->runs, four.masks[k]->runs);
}

}  // namespace nightmap::ghosts_test
