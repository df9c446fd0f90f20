// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/moving.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "stages/labels/moving/moving_output.h"

namespace nightmap::moving_test {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kWall_m = 3;     // depth of the wall
constexpr double kBoard_m = 1.4;  // and of the board before it
constexpr int kNumFrames = 24;

// A surface's gray at a place, with texture at several sizes.
std::uint8_t GrayAt(double x_m, double y_m, int surface) {
  double gray = 110 + 20 * surface;
  for (const double wave_m : {0.9, 0.31, 0.11, 0.05}) {
    gray += 22 * std::sin(6.28 / wave_m * (x_m + 0.4 * y_m + surface)) *
            std::cos(6.28 / wave_m * (y_m - 0.3 * x_m));
  }
  return static_cast<std::uint8_t>(std::clamp(gray, 0.0, 255.0));
}

// A camera that moves to the right looks at a wall; a board of 0.5 x 0.7 m is before it.
struct Scene {
  double camera_m_per_frame = 0.01;
  double board_m_per_frame = 0.06;
  int first_step = 0;  // the frame in which the board still stands

  double BoardLeft_m(int frame) const {
    return -0.8 + board_m_per_frame * std::max(0, frame - first_step);
  }

  // Whether the pixel shows the board.
  bool IsBoard(int frame, int x, int y) const {
    const double x_m = (x - 159.5) / 260 * kBoard_m + camera_m_per_frame * frame;
    const double y_m = (y - 119.5) / 260 * kBoard_m;
    return std::abs(y_m) < 0.35 && x_m >= BoardLeft_m(frame) && x_m < BoardLeft_m(frame) + 0.5;
  }

  RgbdImages See(const FrameRecord& record) const {
    const int frame = record.frame_idx;
    RgbdImages images;
    images.color = {kWidth, kHeight, 3, std::vector<std::uint8_t>(kWidth * kHeight * 3)};
    images.depth = {kWidth, kHeight, 1, std::vector<float>(kWidth * kHeight)};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool is_board = IsBoard(frame, x, y);
        const double depth_m = is_board ? kBoard_m : kWall_m;
        const double x_m = (x - 159.5) / 260 * depth_m + camera_m_per_frame * frame;
        const double y_m = (y - 119.5) / 260 * depth_m;
        const auto gray = is_board ? GrayAt(x_m - BoardLeft_m(frame), y_m, 1) : GrayAt(x_m, y_m, 0);
        for (int channel = 0; channel < 3; ++channel) images.color.At(x, y, channel) = gray;
        images.depth.At(x, y) = static_cast<float>(depth_m);
      }
    }
    return images;
  }
};

class MovingTest : public testing::Test {
 protected:
  MovingTest() {
    input_.cameras.resize(1);
    input_.cameras[0].color = Camera{kWidth, kHeight, 260, 260, 159.5, 119.5};
    for (int i = 0; i < kNumFrames; ++i) {
      FrameRecord frame;
      frame.frame_idx = i;
      frame.time_ns = 1'000'000'000 + i * 66'000'000LL;
      frame.color = {"color/" + std::to_string(i), "h"};
      frame.depth = {"depth/" + std::to_string(i), "h"};
      input_.frames.push_back(frame);
    }
    See({});
  }

  void See(const Scene& scene) {
    scene_ = scene;
    input_.load = [scene](const FrameRecord& frame) { return scene.See(frame); };
  }

  MovingResult Run(int num_threads = 2) const {
    MovingOptions options;
    options.margin_px = 0;
    Progress progress("moving", false);
    return RunMoving(options, input_, progress, num_threads);
  }

  Scene scene_;
  MovingInput input_;
};

double MeanShare(const MovingResult& result) {
  double sum = 0;
  for (const double share : result.moving_shares) sum += share;
  return sum / static_cast<double>(result.moving_shares.size());
}

TEST_F(MovingTest, ABoardThatPassesIsFoundAndTheWallIsNot) {
  const MovingResult result = Run();
  EXPECT_EQ(result.num_pairs, kNumFrames - 1);
  EXPECT_EQ(result.num_pairs_without_motion, 0);
  double both = 0, found = 0, truth = 0;
  for (int i = 0; i < kNumFrames; ++i) {
    ASSERT_TRUE(result.masks[static_cast<std::size_t>(i)]);
    const GrayImage mask = UnpackMask(*result.masks[static_cast<std::size_t>(i)]);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        both += mask.At(x, y) != 0 && scene_.IsBoard(i, x, y);
        found += mask.At(x, y) != 0;
        truth += scene_.IsBoard(i, x, y);
      }
    }
  }
  EXPECT_GT(both / truth, 0.95) << "recall";
  EXPECT_GT(both / found, 0.9) << "precision";
}

TEST_F(MovingTest, WhereNothingMovesNothingIsMasked) {
  See({.camera_m_per_frame = 0.02, .board_m_per_frame = 0});
  EXPECT_LT(MeanShare(Run()), 0.002);
  See({.camera_m_per_frame = 0, .board_m_per_frame = 0});
  EXPECT_EQ(MeanShare(Run()), 0);
}

TEST_F(MovingTest, IsTheSameAtAnyNumberOfThreads) {
  const MovingResult one = Run(1);
  const MovingResult four = Run(4);
  ASSERT_GT(MeanShare(one), 0.01);
  for (std::size_t i = 0; i < one.masks.size(); ++i)
    EXPECT_EQ(one.masks[i]->runs, four.masks[i]->runs);
}

TEST_F(MovingTest, AFrameThatCannotBeReadHasNoMask) {
  input_.load = [scene = scene_](const FrameRecord& frame) {
    if (frame.frame_idx == 7) throw DataError("{}: truncated", frame.color.path);
    return scene.See(frame);
  };
  const MovingResult result = Run();
  EXPECT_EQ(result.skipped, std::vector<std::string>{"color/7: truncated"});
  EXPECT_EQ(result.num_pairs_without_motion, 2);
  const auto frames = FramesWithMasks(input_.frames, result, "masks.h5");
  EXPECT_EQ(MasksOf(result).size(), kNumFrames - 1U);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(result.masks[i].has_value(), i != 7);
    EXPECT_EQ(frames[i].others.contains("mask"), i != 7);
  }
}

TEST_F(MovingTest, TheListTellsOfAnyChangeOfAMask) {
  MovingResult result = Run();
  const auto list = [&] { return FramesToCsv(FramesWithMasks(input_.frames, result, "masks.h5")); };
  const std::string before = list();
  GrayImage mask = UnpackMask(*result.masks[3]);
  mask.pixels.back() = static_cast<std::uint8_t>(255 - mask.pixels.back());
  result.masks[3] = PackMask(result.masks[3]->time_ns, mask);
  const std::string changed = list();
  EXPECT_NE(changed, before);
  std::swap(mask.width, mask.height);
  result.masks[3] = PackMask(result.masks[3]->time_ns, mask);
  EXPECT_NE(list(), changed);
}

TEST_F(MovingTest, FramesWithoutDepthHaveEmptyMasks) {
  input_.load = [scene = scene_](const FrameRecord& frame) {
    RgbdImages images = scene.See(frame);
    images.depth = {};
    return images;
  };
  const MovingResult result = Run();
  EXPECT_TRUE(result.skipped.empty());
  EXPECT_EQ(MeanShare(result), 0);
  EXPECT_EQ(MasksOf(result).size(), static_cast<std::size_t>(kNumFrames));
}

// Labels on the board of a scene: what they say may move is decided as a whole.
class LabelledBoardTest : public MovingTest {
 protected:
  void SeeLabelled(const Scene& scene) {
    See(scene);
    input_.load = [scene](const FrameRecord& frame) {
      RgbdImages images = scene.See(frame);
      images.moving = {kWidth, kHeight, 1, std::vector<std::uint8_t>(kWidth * kHeight)};
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          images.moving.At(x, y) = scene.IsBoard(frame.frame_idx, x, y) ? 255 : 0;
        }
      }
      return images;
    };
  }

  // The share counts the pixels of the board in a frame.
  double MaskedShare(const MovingResult& result, int frame) const {
    const GrayImage mask = UnpackMask(*result.masks[static_cast<std::size_t>(frame)]);
    double masked = 0, all = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (!scene_.IsBoard(frame, x, y)) continue;
        masked += mask.At(x, y) != 0;
        ++all;
      }
    }
    return masked / all;
  }
};

TEST_F(LabelledBoardTest, WhatPassesIsMaskedWhole) {
  SeeLabelled({.camera_m_per_frame = 0.01, .board_m_per_frame = 0.06});
  const MovingResult result = Run();
  for (int i = 0; i < kNumFrames; ++i) EXPECT_GT(MaskedShare(result, i), 0.95) << i;
}

TEST_F(LabelledBoardTest, WhatStandsIsNotMasked) {
  for (const double camera_m_per_frame : {0.0, 0.02}) {
    SeeLabelled({.camera_m_per_frame = camera_m_per_frame, .board_m_per_frame = 0});
    const MovingResult result = Run();
    for (int i = 0; i < kNumFrames; ++i) EXPECT_EQ(MaskedShare(result, i), 0) << i;
  }
}

TEST_F(LabelledBoardTest, WhoLeavesIsMaskedFromThenOn) {
  SeeLabelled({.camera_m_per_frame = 0.005, .board_m_per_frame = 0.06, .first_step = 12});
  const MovingResult result = Run();
  for (int i = 0; i < kNumFrames; ++i) {
    const double share = MaskedShare(result, i);
    EXPECT_TRUE(i > 12 || share == 0) << i << ": " << share;
    EXPECT_TRUE(i <= 12 || share > 0.95) << i << ": " << share;
  }
}

TEST_F(LabelledBoardTest, WhereNothingIsKnownLabelsDecide) {
  SeeLabelled({.camera_m_per_frame = 0, .board_m_per_frame = 0});
  for (std::size_t i = 0; i < input_.frames.size(); ++i) {
    input_.frames[i].sequence_idx = static_cast<int>(i);  // so that no frame is compared
  }
  const MovingResult result = Run();
  for (int i = 0; i < kNumFrames; ++i) EXPECT_GT(MaskedShare(result, i), 0.95) << i;
}

TEST_F(MovingTest, LabelsOfAnotherSizeFailTheFrame) {
  input_.load = [scene = scene_](const FrameRecord& frame) {
    RgbdImages images = scene.See(frame);
    if (frame.frame_idx == 3) images.moving = {64, 48, 1, std::vector<std::uint8_t>(64 * 48)};
    return images;
  };
  const MovingResult result = Run();
  ASSERT_EQ(result.skipped.size(), 1U);
  EXPECT_NE(result.skipped[0].find("64 x 48"), std::string::npos) << result.skipped[0];
  EXPECT_FALSE(result.masks[3]);
}

TEST_F(MovingTest, SequencesAreNotCompared) {
  for (std::size_t i = kNumFrames / 2; i < kNumFrames; ++i) input_.frames[i].sequence_idx = 1;
  EXPECT_EQ(Run().num_pairs, kNumFrames - 2);
}

}  // namespace nightmap::moving_test
