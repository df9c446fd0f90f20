// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/wall_normals.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "pipeline/base/random.h"

namespace nightmap::wall_normals_test {

using Points = std::vector<Eigen::Vector2d>;
constexpr double kMaxRms_m = 0.03;

// Two walls of 2 m that meet in a corner, a point each 5 cm with noise.
Points Corner(double noise_m) {
  Random random(3);
  Points points;
  const auto noise = [&] { return random.Uniform(-noise_m, noise_m); };
  for (int i = 0; i < 40; ++i) points.emplace_back(0.05 * i, noise());
  for (int i = 1; i < 40; ++i) points.emplace_back(1.95 + noise(), 0.05 * i);
  return points;
}

double Degrees(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return std::acos(std::min(1.0, std::abs(a.dot(b)))) * 180 / M_PI;
}

TEST(WallNormals, APointHasTheNormalOfItsOwnWall) {
  const Points points = Corner(0.01);
  const Points normals = WallNormals(points, kMaxRms_m);
  ASSERT_EQ(normals.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 37 && i < 42) continue;  // the corner itself is of both
    EXPECT_NEAR(normals[i].norm(), 1, 1e-9);
    EXPECT_LT(Degrees(normals[i], i < 40 ? Eigen::Vector2d(0, 1) : Eigen::Vector2d(1, 0)), 6) << i;
  }
}

TEST(WallNormals, TurnWithThePoints) {
  const Eigen::Rotation2Dd turn(0.7);
  Points turned;
  for (const Eigen::Vector2d& point : Corner(0.01)) turned.push_back(turn * point);
  const Points normals = WallNormals(Corner(0.01), kMaxRms_m);
  const Points turned_normals = WallNormals(turned, kMaxRms_m);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    EXPECT_LT(Degrees(turned_normals[i], turn * normals[i]), 0.01);
  }
}

TEST(WallNormals, WhatIsNoWallHasNone) {
  Random random(4);
  Points scattered;
  for (int i = 0; i < 60; ++i) {
    scattered.emplace_back(random.Uniform(0, 3), random.Uniform(0, 3));
  }
  for (const Eigen::Vector2d& normal : WallNormals(scattered, kMaxRms_m)) {
    EXPECT_TRUE(normal.isZero());
  }
  EXPECT_TRUE(WallNormals({}, kMaxRms_m).empty());
  for (const Eigen::Vector2d& normal : WallNormals({{0, 0}, {1, 0}, {2, 0}}, kMaxRms_m)) {
    EXPECT_TRUE(normal.isZero());
  }
}

// A wall seen along a corridor has a point per metre.
TEST(WallNormals, APointFarFromItsNeighboursIsOnTheirWall) {
  Points points;
  for (int beam = 40; beam >= 7; --beam) points.emplace_back(1 / std::tan(beam * M_PI / 180), 1);
  for (const Eigen::Vector2d& normal : WallNormals(points, kMaxRms_m)) {
    EXPECT_LT(Degrees(normal, {0, 1}), 0.01);
  }
}

}  // namespace nightmap::wall_normals_test
