// SPDX-License-Identifier: Apache-2.0
// Boards at several depths before a wall, of which one moves.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/camera/follow_corners.h"
#include "stages/labels/moving/small_frame.h"

namespace nightmap::epipolar_check_test {

constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr int kWindow_px = 15;
constexpr double kWall_m = 4;

// An upright rectangle that faces the camera.
struct Board {
  double depth_m = 0;
  double left_m = 0, top_m = 0;
  double width_m = 0, height_m = 0;
};

const std::vector<Board> kFurniture = {{3.2, -1.9, -0.2, 0.9, 1.6},
                                       {2.7, 0.7, -1.3, 0.8, 0.9},
                                       {2.2, -1.2, -1.1, 0.6, 0.7},
                                       {1.8, 0.55, 0.1, 0.5, 0.6},
                                       {2.5, -0.35, 0.55, 0.5, 0.5}};
const Board kMover{1.5, -0.25, -0.4, 0.5, 0.55};

inline double GrayOf(double x_m, double y_m, int board) {
  double gray = 120 + 12 * (board % 3);
  for (const double wave_m : {0.83, 0.37, 0.23, 0.13}) {
    gray += 20 * std::sin(6.28 / wave_m * (x_m + 0.4 * y_m + board)) *
            std::cos(6.28 / wave_m * (y_m - 0.3 * x_m));
  }
  return gray;
}

inline SmallCamera MakeCamera(double k1 = 0) {
  RgbdCamera camera;
  camera.color = Camera{kWidth, kHeight, 260, 260, 159.5, 119.5};
  camera.color.k1 = k1;
  return Shrink(camera);
}

struct View {
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
  double yaw_rad = 0;
  Eigen::Vector2d mover_m = Eigen::Vector2d::Zero();  // to the right and down, from its first place
  double mover_gray = 0;                              // added to its gray
};

// A camera's view: the frame, and which pixels show the mover.
struct Picture {
  SmallFrame frame;
  Image<std::uint8_t> is_mover;

  bool ShowsMover(const Eigen::Vector2f& at) const {
    return is_mover.At(cvRound(at.x()), cvRound(at.y())) != 0;
  }
};

inline Picture See(const SmallCamera& camera, const View& view) {
  std::vector<Board> boards = kFurniture;
  boards.push_back(kMover);
  boards.back().left_m += view.mover_m.x();
  boards.back().top_m += view.mover_m.y();
  constexpr auto kNumPixels = static_cast<std::size_t>(kWidth) * kHeight;
  Picture picture;
  picture.frame.gray = {kWidth, kHeight, 1, std::vector<std::uint8_t>(kNumPixels)};
  picture.is_mover = picture.frame.gray;
  const Eigen::AngleAxisd turn(view.yaw_rad, Eigen::Vector3d::UnitY());
  Random noise(7, static_cast<std::uint64_t>(1000 * (view.at_m.norm() + view.yaw_rad)));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector3d ray = turn * camera.gray.BackProject({x, y}, 1);
      double nearest_m = kWall_m;
      const auto at_depth = [&](double depth_m) -> Eigen::Vector3d {
        return view.at_m + ray * ((depth_m - view.at_m.z()) / ray.z());
      };
      double gray = GrayOf(at_depth(kWall_m).x(), at_depth(kWall_m).y(), 0);
      for (std::size_t b = 0; b < boards.size(); ++b) {
        const Board& board = boards[b];
        const double x_m = at_depth(board.depth_m).x() - board.left_m;
        const double y_m = at_depth(board.depth_m).y() - board.top_m;
        if (board.depth_m >= nearest_m || x_m < 0 || x_m > board.width_m || y_m < 0 ||
            y_m > board.height_m) {
          continue;
        }
        nearest_m = board.depth_m;
        const bool is_mover = b == kFurniture.size();
        gray = GrayOf(x_m, y_m, static_cast<int>(b) + 1) + (is_mover ? view.mover_gray : 0);
        picture.is_mover.At(x, y) = is_mover;
      }
      picture.frame.gray.At(x, y) =
          static_cast<std::uint8_t>(std::clamp(gray + 2 * noise.Gaussian(), 0.0, 255.0));
    }
  }
  picture.frame.corners = Corners(picture.frame.gray, 10);
  picture.frame.pyramid = FlowPyramid(picture.frame.gray, {kWindow_px});
  return picture;
}

}  // namespace nightmap::epipolar_check_test
