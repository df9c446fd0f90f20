// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/mesh/implicit_surface.h"

#include <cmath>

#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::implicit_surface_test {

constexpr double kRadius_m = 0.1;
constexpr double kSquare_m = 0.06;

// In a cube of 0.4 m around the origin, many at the same height.
std::vector<CloudPoint> Points() {
  std::vector<CloudPoint> points;
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    CloudPoint& point = points.emplace_back();
    const double z_m = 0.05 * static_cast<double>(random.Index(9)) - 0.2;
    point.position_in_map =
        Eigen::Vector3d(random.Uniform(-0.2, 0.2), random.Uniform(-0.2, 0.2), z_m).cast<float>();
    point.normal_in_map = Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian())
                              .normalized()
                              .cast<float>();
    for (auto& channel : point.rgb) channel = static_cast<std::uint8_t>(random.Index(256));
  }
  return points;
}

std::vector<Eigen::Vector3d> Places() {
  std::vector<Eigen::Vector3d> places;
  Random random(6);
  for (int i = 0; i < 100; ++i) {
    places.emplace_back(
        random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3), random.Uniform(-0.3, 0.3));
  }
  return places;
}

TEST(ImplicitSurface, IsTheWeightedMeanOverAllPointsWithinTheRadius) {
  const auto points = Points();
  const ImplicitSurface surface(points, kSquare_m);
  int num_near = 0;
  for (const Eigen::Vector3d& place : Places()) {
    double weights = 0, distance = 0, red = 0, nearest_m = kRadius_m;
    for (const CloudPoint& point : points) {
      const Eigen::Vector3d offset = place - point.position_in_map.cast<double>();
      if (offset.norm() >= kRadius_m) continue;
      const double weight = std::pow(1 - std::pow(offset.norm() / kRadius_m, 2), 4);
      weights += weight;
      distance += weight * point.normal_in_map.cast<double>().dot(offset);
      red += weight * point.rgb[0];
      nearest_m = std::min(nearest_m, offset.norm());
    }
    const SurfaceSample sample = surface.At(place, kRadius_m);
    EXPECT_EQ(std::isnan(sample.distance_m), weights == 0);
    if (weights == 0) continue;
    ++num_near;
    EXPECT_NEAR(sample.distance_m, distance / weights, 1e-12);
    EXPECT_NEAR(sample.rgb.x(), red / weights, 1e-9);
    EXPECT_NEAR(sample.nearest_m, nearest_m, 1e-12);
  }
  EXPECT_GT(num_near, 30);
}

// As the clouds of other tiles come in another order.
TEST(ImplicitSurface, ItsBitsDoNotDependOnTheOrderOfThePoints) {
  auto points = Points();
  const ImplicitSurface surface(points, kSquare_m);
  std::ranges::reverse(points);
  const ImplicitSurface reversed(points, kSquare_m);
  for (const Eigen::Vector3d& place : Places()) {
    const SurfaceSample sample = surface.At(place, kRadius_m),
                        other = reversed.At(place, kRadius_m);
    if (std::isnan(sample.distance_m)) continue;
    EXPECT_EQ(sample.distance_m, other.distance_m);
    EXPECT_EQ(sample.rgb, other.rgb);
    EXPECT_EQ(sample.normal, other.normal);
  }
}

TEST(ImplicitSurface, NothingIsNearWithoutPoints) {
  const SurfaceSample sample = ImplicitSurface({}, kSquare_m).At({0, 0, 0}, kRadius_m);
  EXPECT_TRUE(std::isnan(sample.distance_m));
  EXPECT_TRUE(std::isinf(sample.nearest_m));
}

}  // namespace nightmap::implicit_surface_test
