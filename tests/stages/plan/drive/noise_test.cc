// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/noise.h"

#include <cmath>

#include "stages/plan/drive/drive_output.h"
#include "tests/stages/plan/drive/hall.h"
#include "tests/stages/plan/drive/random_path.h"

namespace nightmap::noise_test {

constexpr NoiseOptions kSmall{0.05, 0.01, 0.01, 1, 0};

DriveOptions WithNoise(const NoiseOptions& noise, int seed) {
  DriveOptions options;
  options.noise = noise;
  options.noise.seed = seed;
  options.max_duration_s = 200;
  return options;
}

TEST(Noise, NoneLeavesAllAsItIs) {
  Noise noise({.seed = 7}, 0.4, 0.05);
  const PlanarPose pose{{1.1, -2.3}, 0.7};
  const Twist command{0.3, -0.123457};
  EXPECT_EQ(noise.Moved(command).v_m_s, command.v_m_s);
  EXPECT_EQ(noise.Moved(command).omega_rad_s, command.omega_rad_s);
  EXPECT_EQ(noise.Told(pose).point_in_map, pose.point_in_map);
  EXPECT_EQ(noise.Told(pose).heading_rad, pose.heading_rad);
}

// Errors of the wheels' travel, reconstructed from the twists.
TEST(Noise, WheelsErrApartInProportion) {
  constexpr double kDistance_m = 0.4;
  constexpr int kNum = 20000;
  Noise noise({0.1, 0, 0, 1, 3}, kDistance_m, 0.05);
  double left_sum = 0;
  double right_sum = 0;
  double product_sum = 0;
  for (int i = 0; i < kNum; ++i) {
    const Twist moved = noise.Moved({0.5, 1});  // wheels at 0.3 and 0.7 m/s
    const double left = (moved.v_m_s - 0.2 * moved.omega_rad_s) / 0.3 - 1;
    const double right = (moved.v_m_s + 0.2 * moved.omega_rad_s) / 0.7 - 1;
    left_sum += left * left;
    right_sum += right * right;
    product_sum += left * right;
  }
  EXPECT_NEAR(std::sqrt(left_sum / kNum), 0.1, 0.002);
  EXPECT_NEAR(std::sqrt(right_sum / kNum), 0.1, 0.002);
  EXPECT_NEAR(product_sum / kNum, 0, 0.0005);
  EXPECT_TRUE(noise.Moved({0, 0}).IsRest());
}

// The correlation from one period to the next is exp(-period / time).
TEST(Noise, ToldPosesErrAsSaidAndForAsLong) {
  constexpr int kNum = 100000;
  constexpr double kPeriod_s = 0.1;
  for (const double time_s : {0.0, 0.05, 0.5}) {
    Noise noise({0, 0.02, 0.03, time_s, 5}, 0.4, kPeriod_s);
    const PlanarPose pose{{3, 4}, 3.1};
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    Eigen::Vector3d squares = Eigen::Vector3d::Zero();
    Eigen::Vector3d products = Eigen::Vector3d::Zero();
    for (int i = 0; i < kNum; ++i) {
      const PlanarPose told = noise.Told(pose);
      EXPECT_LE(std::abs(told.heading_rad), 180 * kDegrees + 1e-12);
      const Eigen::Vector2d off = told.point_in_map - pose.point_in_map;
      const Eigen::Vector3d error(off.x(), off.y(), WrapAngle(told.heading_rad - pose.heading_rad));
      squares += error.cwiseAbs2();
      products += error.cwiseProduct(last);
      last = error;
    }
    const Eigen::Vector3d sigma = (squares / kNum).cwiseSqrt();
    EXPECT_NEAR(sigma.x(), 0.02, 0.001) << time_s;
    EXPECT_NEAR(sigma.y(), 0.02, 0.001) << time_s;
    EXPECT_NEAR(sigma.z(), 0.03, 0.0015) << time_s;
    for (int axis = 0; axis < 3; ++axis) {
      const double correlation = products[axis] / squares[axis];
      EXPECT_NEAR(correlation, std::exp(-kPeriod_s / time_s), 0.02) << time_s;
    }
  }
}

TEST(NoisyDrive, ArrivesWithEverySeed) {
  const DriveInputs inputs = Hall();
  for (const double time_s : {0.0, 1.0, 10.0}) {
    NoiseOptions noise = kSmall;
    noise.localization_time_s = time_s;
    for (int seed = 0; seed < 20; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", time " << time_s);
      const DriveResult result = Drive(WithNoise(noise, seed), inputs);
      const PlanarPose& last = result.steps.back().pose;
      const double off_m = (last.point_in_map - Eigen::Vector2d(4, 5)).norm();
      EXPECT_LE(off_m, 0.05);
      EXPECT_GT(off_m, 1e-4);  // by the true pose, of which the controller does not know
      EXPECT_EQ(result.position_error_m, off_m);
      EXPECT_LE(std::abs(last.heading_rad - 90 * kDegrees), 5 * kDegrees);
      EXPECT_LT(result.Duration_s(), 60);  // without noise 20
    }
  }
}

TEST(NoisyDrive, SeedsDecideAllOfIt) {
  const DriveInputs inputs = Hall();
  const std::string csv = DriveToCsv(Drive(WithNoise(kSmall, 1), inputs));
  EXPECT_EQ(DriveToCsv(Drive(WithNoise(kSmall, 1), inputs)), csv);
  EXPECT_NE(DriveToCsv(Drive(WithNoise(kSmall, 2), inputs)), csv);
  EXPECT_EQ(DriveToCsv(Drive(WithNoise({}, 1), inputs)),
            DriveToCsv(Drive(WithNoise({}, 2), inputs)));
}

// Noise of told poses changes commands but not the motion; slipping wheels change the motion.
TEST(NoisyDrive, PosesFollowFromCommandsButForTheWheels) {
  NoiseOptions noise = kSmall;
  for (const double wheel_noise : {0.0, 0.05}) {
    noise.wheel_noise = wheel_noise;
    const DriveResult result = Drive(WithNoise(noise, 4), Hall());
    double farthest_m = 0;
    double length_m = 0;
    for (std::size_t i = 1; i < result.steps.size(); ++i) {
      const DriveStep& before = result.steps[i - 1];
      const Eigen::Vector2d& point = result.steps[i].pose.point_in_map;
      const PlanarPose next = Advance(before.pose, before.command, result.period_s);
      farthest_m = std::max(farthest_m, (next.point_in_map - point).norm());
      length_m += (point - before.pose.point_in_map).norm();
    }
    EXPECT_EQ(farthest_m > 0, wheel_noise > 0);
    EXPECT_LT(farthest_m, 0.005);  // of at most 0.025 m a period
    EXPECT_NEAR(result.length_m, length_m, 1e-3);
  }
}

// With a large error of the told poses the robot may hit obstacles, and the drive must report it.
// Every drive either arrives clear of all obstacles or reports where it collided.
TEST(NoisyDrive, CollisionsAreThoseOfTheTruePose) {
  int num_collisions = 0;
  int num_arrived = 0;
  for (int seed = 0; seed < 60; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    DriveInputs inputs{RandomBuilding(random), {}};
    inputs.path = {{RandomPaths(inputs.grid, 0.2).Draw(random)}, 0, 0.2, false};
    if (inputs.path.legs_in_map[0].empty()) continue;
    DriveOptions options = WithNoise({0.1, 0.03, 0.03, 1, 0}, seed);
    options.position_tolerance_m = 1;
    options.heading_tolerance_deg = 180;
    SCOPED_TRACE(seed);
    const ObstacleDistances distances(inputs.grid, true, 1);
    const auto clearance_m = [&](const Eigen::Vector2d& point_in_map) {
      return distances.Clearance_m(inputs.grid.ToCells(point_in_map));
    };
    try {
      const DriveResult result = Drive(options, inputs);
      for (const DriveStep& step : result.steps) {
        EXPECT_GE(clearance_m(step.pose.point_in_map), 0.2 - 1e-5);
      }
      ++num_arrived;
    } catch (const ThresholdError& error) {
      const std::string what = error.what();
      if (what.find("collides") == std::string::npos) continue;
      EXPECT_NE(what.find("noise"), std::string::npos) << what;
      double x_m = 0;
      double y_m = 0;
      const auto at = what.find(" at ");
      ASSERT_EQ(std::sscanf(what.c_str() + at, " at %lf,%lf,", &x_m, &y_m), 2) << what;
      EXPECT_LT(clearance_m({x_m, y_m}), 0.2 + 1e-3) << what;
      EXPECT_GT(clearance_m({x_m, y_m}), 0.1) << what;
      ++num_collisions;
    }
  }
  EXPECT_GT(num_arrived, 10);
  EXPECT_GT(num_collisions, 2);
}

// A robot that is planned for with some room to spare does not collide.
TEST(NoisyDrive, RoomInThePlanIsRoomForNoise) {
  int num_drives = 0;
  for (int seed = 0; num_drives < 40; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    DriveInputs inputs{RandomBuilding(random), {}};
    inputs.path = {{RandomPaths(inputs.grid, 0.24).Draw(random)}, 0, 0.24, false};
    if (inputs.path.legs_in_map[0].empty()) continue;
    ++num_drives;
    DriveOptions options = WithNoise(kSmall, seed);
    options.robot_radius_m = 0.2;
    SCOPED_TRACE(seed);
    const DriveResult result = Drive(options, inputs);
    EXPECT_GE(result.min_clearance_m, 0.2 - 1e-5);
    EXPECT_LE(result.position_error_m, 0.05);
  }
}

TEST(NoisyDrive, ToleranceIsOfTheTruePose) {
  const NoiseOptions noise{.position_noise_m = 0.1};
  int num_off = 0;
  for (int seed = 0; seed < 10; ++seed) {
    try {
      EXPECT_LE(Drive(WithNoise(noise, seed), Hall()).position_error_m, 0.05);
    } catch (const ThresholdError& error) {
      num_off += std::string(error.what()).find("off the goal") != std::string::npos ? 1 : 0;
    }
  }
  EXPECT_GE(num_off, 3);
}

}  // namespace nightmap::noise_test
