// SPDX-License-Identifier: Apache-2.0
// Where the landmarks that the robot saw just now lie among those of a place that it left long ago.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid2.h"

namespace nightmap {

struct SubmapMatchOptions {
  double max_distance_m = 0.06;
  OPTION_AT("max_loop_distance_m", max_distance_m, {0.001, 10},
            "distance between a landmark and itself, met again, under the loop's pose");
  int min_pairs = 8;
  OPTION_AT("min_loop_landmarks", min_pairs, {3, 10000},
            "landmarks that are met again at a place, at least");
  OPTION(double, max_rival_ratio, 0.7, {0, 1},
         "share of them that may lie as well at another place; more, and the place is ambiguous");
  REGISTER_OPTIONS();
};

struct SubmapLandmark {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // metres; z up
  std::array<std::uint8_t, 32> descriptor{};
};

struct SubmapMatch {
  Rigid2 now_from_then;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of x, y (m), heading (rad)
  std::vector<std::pair<int, int>> pairs;                // indices in `now` and `then`
};

// The pose under which most landmarks of one submap lie on landmarks of the other that look and are
// as high alike. `expected` is now_from_then by the filter, with its covariance: pairs are tried
// within 4 sigmas of it. Any two of the 250 best looking pairs make a hypothesis,
// as in RANSAC, but nothing is random. None when fewer than `min_pairs` agree, or when another
// pose, as between tiles that look alike, has `max_rival_ratio` of the pairs of the best: then the
// place is ambiguous. Deterministic.
std::optional<SubmapMatch> MatchSubmaps(const SubmapMatchOptions& options,
                                        const std::vector<SubmapLandmark>& now,
                                        const std::vector<SubmapLandmark>& then,
                                        const Rigid2& expected,
                                        const Eigen::Matrix3d& covariance);

}  // namespace nightmap
