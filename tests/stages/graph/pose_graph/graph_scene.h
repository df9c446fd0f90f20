// SPDX-License-Identifier: Apache-2.0
// A pose graph of random poses, with its truth and a start beside it.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/io/odometry_io.h"
#include "tests/geometry/pose_matches.h"

namespace nightmap {

inline constexpr int kNumNodes = 40;

inline Vector6d Noise(double sigma, Random& random) {
  Vector6d noise;
  for (int i = 0; i < 6; ++i) noise[i] = sigma * random.Gaussian();
  return noise;
}

struct GraphScene {
  std::vector<PoseEdge> edges;
  std::map<int, Rigid3> truth;
  std::map<int, Rigid3> start;
};

// A chain of frames 3, 10, 17 .. and as many edges between random ends, in both directions.
inline GraphScene MakeGraphScene(double noise) {
  GraphScene scene;
  Random random(5);
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < kNumNodes; ++i) {
    scene.truth[7 * i + 3] = RandomPose(random);
    if (i > 0) pairs.emplace_back(i - 1, i);
  }
  for (int k = 0; k < kNumNodes; ++k) {
    const int a = static_cast<int>(random.Index(kNumNodes));
    const int b = static_cast<int>(random.Index(kNumNodes));
    if (a != b) pairs.emplace_back(a, b);
  }
  for (const auto& [i, j] : pairs) {
    const int a = 7 * i + 3;
    const int b = 7 * j + 3;
    Matrix6d spread = 0.1 * Matrix6d::Identity();
    for (int k = 0; k < 6; ++k) spread.col(k) += Noise(0.03, random);
    const Rigid3 exact = scene.truth[b].Inverse() * scene.truth[a];
    scene.edges.push_back(
        {a, b, PerturbLeft(Noise(noise, random), exact), spread * spread.transpose(), false});
  }
  for (const auto& [idx, pose] : scene.truth) {
    scene.start[idx] = idx == 3 ? pose : PerturbLeft(Noise(0.05, random), pose);
  }
  return scene;
}

}  // namespace nightmap
