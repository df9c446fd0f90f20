// SPDX-License-Identifier: Apache-2.0
// The robot's laser, wheels and the people around it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/error.h"
#include "pipeline/world/laser_scanner.h"
#include "pipeline/world/walkers.h"
#include "pipeline/world/wheel_odometry.h"

namespace nightmap::robot_test {

constexpr double kRoom_m = 8;  // from the origin to each of four walls
constexpr double kFrameRate_hz = 10;

Surface Wall(const Eigen::Vector3d& from, const Eigen::Vector3d& edge) {
  Surface wall;
  wall.origin = from;
  wall.edge_u = edge;
  wall.edge_v = {0, 0, -3};
  wall.label = SurfaceLabel::kWall;
  return wall;
}

// A square room of four walls, centred at the origin.
SyntheticWorld SquareRoom(float tint = 1) {
  const double w = kRoom_m;
  Scene scene;
  scene.surfaces = {Wall({w, -w, 2}, {0, 2 * w, 0}),
                    Wall({w, w, 2}, {-2 * w, 0, 0}),
                    Wall({-w, w, 2}, {0, -2 * w, 0}),
                    Wall({-w, -w, 2}, {2 * w, 0, 0})};
  for (Surface& wall : scene.surfaces) wall.material.tint.setConstant(tint);
  return WorldOfScene(std::move(scene));
}

double RangeToSquareRoom_m(const Eigen::Vector2d& from, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  const double to_x = (kRoom_m - std::copysign(1.0, c) * from.x()) / std::abs(c);
  const double to_y = (kRoom_m - std::copysign(1.0, s) * from.y()) / std::abs(s);
  return std::min(to_x, to_y);
}

RobotDrive StandingAt(const Eigen::Vector2d& position, double heading_rad) {
  const RoutePoint point{position, heading_rad, 0};
  return {std::vector<RoutePoint>(11, point), kFrameRate_hz};
}

// An arc of about 15 m with straight parts and turns to both sides.
RobotDrive Winding() {
  std::vector<RoutePoint> frames;
  Eigen::Vector2d position(1, -2);
  for (int i = 0; i <= 150; ++i) {
    const double heading_rad = 0.7 + 1.3 * std::sin(0.05 * i);
    frames.push_back({position, heading_rad, 0});
    position += 0.1 * Eigen::Vector2d(std::cos(heading_rad - 0.1), std::sin(heading_rad - 0.1));
  }
  return {frames, kFrameRate_hz};
}

ScannerOptions ExactScanner() {
  ScannerOptions options;
  options.field_of_view_deg = 360;
  options.num_beams = 360;
  options.noise_constant_m = options.noise_per_m = options.miss_ratio = 0;
  options.glass_ratio = options.black_ratio = 0;
  return options;
}

WheelOptions ExactWheels() {
  WheelOptions options;
  options.scale_bias = options.heading_bias_rad_per_m = 0;
  options.distance_noise_m = options.heading_noise_rad = 0;
  return options;
}

std::vector<float> ScanOnce(const SyntheticWorld& world,
                            const RobotDrive& drive,
                            const ScannerOptions& options,
                            const std::vector<Walker>& walkers = {},
                            std::uint64_t noise_seed = 1) {
  return LaserScanner(world, walkers, options, 5).Scan(drive, 0, noise_seed);
}

double BeamAngle_rad(const ScannerOptions& options, std::size_t beam) {
  const double turn = static_cast<double>(beam) / options.num_beams - 0.5;
  return options.field_of_view_deg * std::numbers::pi / 180 * turn;
}

TEST(LaserScanner, RangesAreTheDistancesToTheWalls) {
  const SyntheticWorld room = SquareRoom();
  const Eigen::Vector2d position(1.5, -2.5);
  for (const double field_of_view_deg : {180.0, 360.0}) {
    ScannerOptions options = ExactScanner();
    options.field_of_view_deg = field_of_view_deg;
    const std::vector<float> ranges_m = ScanOnce(room, StandingAt(position, 0.4), options);
    ASSERT_EQ(ranges_m.size(), 360U);
    for (std::size_t i = 0; i < ranges_m.size(); ++i) {
      const double angle_rad = 0.4 + BeamAngle_rad(options, i);
      EXPECT_NEAR(ranges_m[i], RangeToSquareRoom_m(position, angle_rad), 1e-4) << i;
    }
  }
}

// Beam i is taken i / n of the duration after the stamp, from where the robot is then.
TEST(LaserScanner, BeamsOfAScanAreTakenOneAfterTheOther) {
  const std::vector<RoutePoint> frames = {{{0, 0}, 0, 0}, {{0.8, 0.4}, 0.5, 0}};
  const RobotDrive drive(frames, 1);
  ScannerOptions options = ExactScanner();
  options.duration_s = 0.5;
  const SyntheticWorld room = SquareRoom();
  const auto ranges_m = LaserScanner(room, {}, options, 5).Scan(drive, 0.25, 1);
  for (std::size_t i = 0; i < ranges_m.size(); ++i) {
    const double time_s = 0.25 + 0.5 * static_cast<double>(i) / 360;
    const Eigen::Vector2d position(0.8 * time_s, 0.4 * time_s);
    const double angle_rad = 0.5 * time_s + BeamAngle_rad(options, i);
    EXPECT_NEAR(ranges_m[i], RangeToSquareRoom_m(position, angle_rad), 1e-4) << i;
  }
}

TEST(LaserScanner, NoiseGrowsWithTheRangeAsStated) {
  ScannerOptions options = ExactScanner();
  options.noise_constant_m = 0.01;
  options.noise_per_m = 0.01;
  const SyntheticWorld room = SquareRoom();
  const Eigen::Vector2d position(6, 0);  // walls at 2 m to 14 m
  const RobotDrive drive = StandingAt(position, 0);
  double near = 0, far = 0;  // sums of squares
  int num_near = 0, num_far = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const std::vector<float> ranges_m = ScanOnce(room, drive, options, {}, seed);
    for (std::size_t i = 0; i < ranges_m.size(); ++i) {
      const double exact_m = RangeToSquareRoom_m(position, BeamAngle_rad(options, i));
      const double sigma_m = 0.01 + 0.01 * exact_m;
      const double error = (ranges_m[i] - exact_m) / sigma_m;
      (exact_m < 5 ? near : far) += error * error;
      ++(exact_m < 5 ? num_near : num_far);
    }
  }
  ASSERT_GT(num_near, 3000);
  ASSERT_GT(num_far, 3000);
  EXPECT_NEAR(std::sqrt(near / num_near), 1, 0.04);
  EXPECT_NEAR(std::sqrt(far / num_far), 1, 0.04);
}

TEST(LaserScanner, BeamsAreMissedInTheStatedShare) {
  ScannerOptions options = ExactScanner();
  options.miss_ratio = 0.2;
  const SyntheticWorld room = SquareRoom();
  const RobotDrive drive = StandingAt({0, 0}, 0);
  std::ptrdiff_t num_missed = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    num_missed += std::ranges::count(ScanOnce(room, drive, options, {}, seed), 30.0F);
  }
  EXPECT_NEAR(static_cast<double>(num_missed) / (50 * 360), 0.2, 0.015);
}

TEST(LaserScanner, NothingIsMeasuredBeyondTheRange) {
  ScannerOptions options = ExactScanner();
  options.max_range_m = 9;
  const auto ranges_m = ScanOnce(SquareRoom(), StandingAt({0, 0}, 0), options);
  for (std::size_t i = 0; i < ranges_m.size(); ++i) {
    const double exact_m = RangeToSquareRoom_m({0, 0}, BeamAngle_rad(options, i));
    EXPECT_NEAR(ranges_m[i], std::min(exact_m, 9.0), 1e-4);
  }
}

// A stretch of glass is 1 m long, and it is glass from everywhere and for all noise.
TEST(LaserScanner, GlassReturnsNothingFromAnywhere) {
  ScannerOptions options = ExactScanner();
  options.glass_ratio = 0.4;
  const SyntheticWorld room = SquareRoom();
  std::vector<int> is_glass(static_cast<std::size_t>(2 * kRoom_m), -1);  // of the wall x = 8
  for (const Eigen::Vector2d& position : {Eigen::Vector2d(0, 0), {5, 3}, {-4, -6}}) {
    const auto ranges_m = ScanOnce(room, StandingAt(position, 0), options);
    for (std::size_t i = 0; i < ranges_m.size(); ++i) {
      const double angle_rad = BeamAngle_rad(options, i);
      const double range_m = RangeToSquareRoom_m(position, angle_rad);
      const double y = position.y() + range_m * std::sin(angle_rad);
      const double x = position.x() + range_m * std::cos(angle_rad);
      const double place_m = y + kRoom_m;
      if (x < kRoom_m - 1e-6 || std::abs(place_m - std::round(place_m)) < 1e-6) continue;
      int& state = is_glass.at(static_cast<std::size_t>(place_m));
      const int is_missed = ranges_m[i] == 30.0F ? 1 : 0;
      EXPECT_NEAR(ranges_m[i], is_missed == 1 ? 30 : range_m, 1e-4);
      EXPECT_TRUE(state < 0 || state == is_missed) << "at y = " << y;
      state = is_missed;
    }
  }
  const auto num_glass = std::ranges::count(is_glass, 1);
  EXPECT_GE(num_glass, 2);
  EXPECT_LE(num_glass, 12);
  EXPECT_EQ(std::ranges::count(is_glass, -1), 0);
}

TEST(LaserScanner, BlackReturnsNothingBeyondItsRange) {
  ScannerOptions options = ExactScanner();
  options.black_range_m = 9;
  const auto light = ScanOnce(SquareRoom(1), StandingAt({0, 0}, 0), options);
  const auto dark = ScanOnce(SquareRoom(0.2F), StandingAt({0, 0}, 0), options);
  options.black_ratio = 1;
  const auto chosen = ScanOnce(SquareRoom(1), StandingAt({0, 0}, 0), options);
  EXPECT_EQ(dark, chosen);
  for (std::size_t i = 0; i < light.size(); ++i) {
    EXPECT_EQ(dark[i], light[i] > 9 ? 30.0F : light[i]);
  }
  EXPECT_GT(std::ranges::count(dark, 30.0F), 100);
}

TEST(LaserScanner, LegsAppearWhereTheWalkerIs) {
  const Walker walker{{3, -2}, {3, 2}, 0, 1.0, 0.7};
  ScannerOptions options = ExactScanner();
  options.num_beams = 3600;
  options.duration_s = 0;
  const SyntheticWorld room = SquareRoom();
  const RobotDrive drive = StandingAt({0, 0}, 0);
  const LaserScanner scanner(room, {walker}, options, 5);
  for (const double time_s : {0.0, 0.5, 2.9, 5.0}) {
    const auto legs = LegsAt(walker, time_s);
    const std::vector<float> ranges_m = scanner.Scan(drive, time_s, 1);
    std::array<int, 2> num_hits = {0, 0};
    for (std::size_t i = 0; i < ranges_m.size(); ++i) {
      const double angle_rad = BeamAngle_rad(options, i);
      if (ranges_m[i] > RangeToSquareRoom_m({0, 0}, angle_rad) - 0.01) continue;
      const Eigen::Vector2d hit =
          ranges_m[i] * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
      const double to_first_m = (hit - legs[0]).norm();
      const double to_second_m = (hit - legs[1]).norm();
      EXPECT_NEAR(std::min(to_first_m, to_second_m), kLegRadius_m, 1e-4);
      ++num_hits[to_first_m < to_second_m ? 0 : 1];
    }
    EXPECT_GT(num_hits[0] + num_hits[1], 15) << time_s;
  }
  // A laser above them sees no legs.
  options.height_m = 1.2;
  for (const float range_m : ScanOnce(room, drive, options, {walker})) EXPECT_GT(range_m, 7.9);
}

TEST(LaserScanner, SeedDecidesTheNoise) {
  const SyntheticWorld room = SquareRoom();
  const RobotDrive drive = StandingAt({0, 0}, 0);
  const ScannerOptions options;
  EXPECT_EQ(ScanOnce(room, drive, options, {}, 3), ScanOnce(room, drive, options, {}, 3));
  EXPECT_NE(ScanOnce(room, drive, options, {}, 3), ScanOnce(room, drive, options, {}, 4));
}

TEST(Walkers, GoBackAndForthWithoutJumps) {
  const Walker walker{{1, 2}, {4, 6}, 0, 1.2, 3};
  const Eigen::Vector2d along = (walker.to - walker.from).normalized();
  auto before = LegsAt(walker, 0);
  double least_m = 1e9, most_m = -1e9;
  for (double time_s = 0.01; time_s < 20; time_s += 0.01) {
    const auto legs = LegsAt(walker, time_s);
    const Eigen::Vector2d middle = (legs[0] + legs[1]) / 2;
    const double at_m = (middle - walker.from).dot(along);
    EXPECT_NEAR((middle - walker.from - at_m * along).norm(), 0, 1e-9);
    least_m = std::min(least_m, at_m);
    most_m = std::max(most_m, at_m);
    for (std::size_t leg = 0; leg < 2; ++leg) {
      EXPECT_LT((legs[leg] - before[leg]).norm(), 0.025);
    }
    before = legs;
  }
  EXPECT_NEAR(least_m, 0, 0.02);
  EXPECT_NEAR(most_m, 5, 0.02);
}

struct Demo {
  RouteOptions route;
  SyntheticWorld world;
  RobotDrive drive;
};

// The demo building, built once for all tests.
const Demo& DemoBuilding() {
  static const Demo demo = [] {
    BuildingOptions building;
    building.light_map_cell_m = 1;
    building.num_light_samples = 1;
    const RouteOptions route;
    SyntheticWorld world = BuildWorld(building, route, 2);
    RobotDrive drive(SampleFrames(PlanPath(world.layout, route), route), kFrameRate_hz);
    return Demo{route, std::move(world), std::move(drive)};
  }();
  return demo;
}

TEST(Walkers, NeverBlockTheRobotAndTouchNothing) {
  const Demo& demo = DemoBuilding();
  const std::vector<Walker> walkers = PlanWalkers(demo.world, demo.drive, 6, 3);
  ASSERT_EQ(walkers.size(), 6U);
  for (const Walker& walker : walkers) {
    EXPECT_GT((walker.to - walker.from).norm(), 1.0);
    for (double time_s = 0; time_s < demo.drive.Duration_s(); time_s += 0.0037) {
      for (const Eigen::Vector2d& leg : LegsAt(walker, time_s)) {
        EXPECT_GE((leg - demo.drive.At(time_s).position).norm(), kWalkerDistance_m);
      }
    }
    for (double time_s = 0; time_s < 12; time_s += 0.05) {
      for (const Eigen::Vector2d& leg : LegsAt(walker, time_s)) {
        EXPECT_GE(Clearance(demo.world.scene.boxes, leg, 0.02, kLegHeight_m), kLegRadius_m - 0.02);
        EXPECT_TRUE(demo.world.layout.IsIndoors(leg.x(), leg.y()));
      }
    }
  }
}

TEST(Walkers, AreSeenByTheLaser) {
  const Demo& demo = DemoBuilding();
  const std::vector<Walker> walkers = PlanWalkers(demo.world, demo.drive, 4, 3);
  const ScannerOptions options = ExactScanner();
  const LaserScanner empty(demo.world, {}, options, 5);
  for (const Walker& walker : walkers) {
    const LaserScanner scanner(demo.world, {walker}, options, 5);
    int num_scans = 0;
    for (double time_s = 0; time_s + 0.1 < demo.drive.Duration_s(); time_s += 0.5) {
      num_scans += scanner.Scan(demo.drive, time_s, 1) != empty.Scan(demo.drive, time_s, 1);
    }
    EXPECT_GE(num_scans, 2);
  }
}

TEST(Walkers, RefusesMoreThanFit) {
  const SyntheticWorld room = SquareRoom();  // it has no layout, so no place in it is indoors
  EXPECT_THROW(PlanWalkers(room, StandingAt({0, 0}, 0), 1, 1), UsageError);
  EXPECT_TRUE(PlanWalkers(room, StandingAt({0, 0}, 0), 0, 1).empty());
}

TEST(WheelOdometry, IsTheTruthWithoutBiasAndNoise) {
  const RobotDrive drive = Winding();
  for (const double rate_hz : {20.0, 7.0}) {
    WheelOptions options = ExactWheels();
    options.rate_hz = rate_hz;
    const WheelOdometry odometry(drive, options, 1);
    EXPECT_NEAR(odometry.Duration_s(), drive.Duration_s(), 1 / rate_hz);
    const Rigid3 start_from_building = RobotPose(drive.At(0)).Inverse();
    for (std::size_t i = 0; i < odometry.Samples().size(); ++i) {
      const RoutePoint robot = drive.At(odometry.TimeOf_s(i));
      const Eigen::Vector3d expected = (start_from_building * RobotPose(robot)).translation;
      const Eigen::Vector3d& pose = odometry.Samples()[i];
      EXPECT_NEAR((pose.head<2>() - expected.head<2>()).norm(), 0, 1e-9);
      EXPECT_NEAR(pose[2], robot.heading_rad - drive.At(0).heading_rad, 1e-9);
    }
  }
}

double Length_m(const std::vector<Eigen::Vector3d>& poses) {
  double length_m = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    length_m += (poses[i] - poses[i - 1]).head<2>().norm();
  }
  return length_m;
}

TEST(WheelOdometry, HasTheStatedBias) {
  const RobotDrive drive = Winding();
  const WheelOdometry exact(drive, ExactWheels(), 1);
  WheelOptions options = ExactWheels();
  options.scale_bias = 0.03;
  const WheelOdometry scaled(drive, options, 1);
  EXPECT_NEAR(Length_m(scaled.Samples()) / Length_m(exact.Samples()), 1.03, 1e-9);
  EXPECT_NEAR(scaled.Samples().back()[2], exact.Samples().back()[2], 1e-9);
  options = ExactWheels();
  options.heading_bias_rad_per_m = 0.01;
  const WheelOdometry turned(drive, options, 1);
  EXPECT_NEAR(turned.Samples().back()[2] - exact.Samples().back()[2],
              0.01 * Length_m(exact.Samples()),
              1e-9);
}

// The deviations of length and heading over many drives, at two sample rates.
TEST(WheelOdometry, NoiseHasTheStatedDeviationAtAnyRate) {
  const RobotDrive drive = Winding();
  for (const double rate_hz : {10.0, 40.0}) {
    WheelOptions options = ExactWheels();
    options.rate_hz = rate_hz;
    const WheelOdometry exact(drive, options, 1);
    double turned_rad = 0;
    for (std::size_t i = 1; i < exact.Samples().size(); ++i) {
      turned_rad += std::abs(exact.Samples()[i][2] - exact.Samples()[i - 1][2]);
    }
    const double length_m = Length_m(exact.Samples());
    options.distance_noise_m = 0.01;
    options.heading_noise_rad = 0.02;
    double length_square = 0, heading_square = 0;
    constexpr int kNumDrives = 600;
    for (std::uint64_t seed = 0; seed < kNumDrives; ++seed) {
      const WheelOdometry noisy(drive, options, seed);
      length_square += std::pow(Length_m(noisy.Samples()) - length_m, 2);
      heading_square += std::pow(noisy.Samples().back()[2] - exact.Samples().back()[2], 2);
    }
    const double length_sigma_m = std::sqrt(length_square / kNumDrives);
    const double heading_sigma_rad = std::sqrt(heading_square / kNumDrives);
    EXPECT_NEAR(length_sigma_m / (0.01 * std::sqrt(length_m)), 1, 0.12);
    EXPECT_NEAR(heading_sigma_rad / (0.02 * std::sqrt(turned_rad)), 1, 0.12);
  }
}

TEST(WheelOdometry, IsLinearBetweenSamples) {
  const WheelOdometry odometry(Winding(), WheelOptions{}, 1);
  for (std::size_t i = 0; i + 1 < odometry.Samples().size(); i += 13) {
    const Eigen::Vector3d middle =
        odometry.At((odometry.TimeOf_s(i) + odometry.TimeOf_s(i + 1)) / 2);
    const Eigen::Vector3d mean = (odometry.Samples()[i] + odometry.Samples()[i + 1]) / 2;
    EXPECT_LT((middle - mean).norm(), 1e-9);
  }
}

TEST(RobotDrive, FollowsTheFramesInStraightLines) {
  const RobotDrive drive = Winding();
  EXPECT_NEAR(drive.Duration_s(), 15, 1e-9);
  const RoutePoint a = drive.At(3.1);
  const RoutePoint b = drive.At(3.2);
  const RoutePoint between = drive.At(3.13);
  EXPECT_LT((between.position - (0.7 * a.position + 0.3 * b.position)).norm(), 1e-9);
  EXPECT_NEAR(between.heading_rad, 0.7 * a.heading_rad + 0.3 * b.heading_rad, 1e-9);
  EXPECT_EQ(drive.At(99).position, drive.At(15).position);
  const Rigid3 pose = RobotPose(a);
  const Eigen::Vector3d forward = pose.rotation * Eigen::Vector3d::UnitX();
  EXPECT_NEAR(std::atan2(forward.y(), forward.x()), a.heading_rad, 1e-9);
}

}  // namespace nightmap::robot_test
