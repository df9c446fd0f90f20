// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/move_off_obstacles.h"

#include <algorithm>

#include "stages/plan/drive/path_track.h"

namespace nightmap {
namespace {

constexpr double kPointSpacing_m = 0.02;
constexpr double kGradientStep_m = 1e-3;
constexpr double kEndSlope = 0.3;  // largest sideways move per metre from an end
constexpr int kNumPasses = 10;

Eigen::Vector2d Gradient(const ClearanceMap& map, const Eigen::Vector2d& point) {
  const auto difference = [&](const Eigen::Vector2d& step) {
    return (map.Room_m(point + step) - map.Room_m(point - step)) / (2 * step.norm());
  };
  return {difference({kGradientStep_m, 0}), difference({0, kGradientStep_m})};
}

Eigen::Vector2d MoveOff(const ClearanceMap& map,
                        const Eigen::Vector2d& point,
                        double margin_m,
                        double max_move_m) {
  Eigen::Vector2d best = point;
  double best_m = map.Room_m(point);
  for (int pass = 0; pass < kNumPasses && best_m < margin_m; ++pass) {
    Eigen::Vector2d move = best + (margin_m - best_m) * Gradient(map, best) - point;
    if (move.norm() > max_move_m) move *= max_move_m / move.norm();
    const double moved_m = map.Room_m(point + move);
    if (moved_m <= best_m) break;
    best = point + move;
    best_m = moved_m;
  }
  return best;
}

}  // namespace

std::vector<Eigen::Vector2d> MoveOffObstacles(const ClearanceMap& map,
                                              const std::vector<Eigen::Vector2d>& path,
                                              double margin_m) {
  const PathTrack track(path);
  const double length_m = track.Length_m();
  const int num_parts = 1 + static_cast<int>(length_m / kPointSpacing_m);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= num_parts; ++i) {
    const double at_m = length_m * i / num_parts;
    const double max_move_m = std::min(margin_m, kEndSlope * std::min(at_m, length_m - at_m));
    points.push_back(MoveOff(map, track.At(at_m), margin_m, max_move_m));
  }
  return points;
}

}  // namespace nightmap
