// SPDX-License-Identifier: Apache-2.0
// Measurements of the wheels: truth without noise, the stated sigmas over many seeds, slip.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "stages/ceiling/synthesize_ceiling/synthesize_ceiling.h"

namespace nightmap::ceiling_wheels_test {

constexpr double kLength_m = 10;
constexpr int kNumSeeds = 400;

SynthesizeCeilingOptions Exact() {
  SynthesizeCeilingOptions options;
  options.wheels.distance_noise_m = 0;
  options.wheels.heading_noise_rad = 0;
  options.wheels.heading_noise_rad_per_root_m = 0;
  options.scale_bias_sigma = 0;
  options.heading_bias_sigma_rad_per_m = 0;
  return options;
}

RobotDrive Straight() { return DriveCeilingLegs({{{0, 0}, {kLength_m, 0}}}, {}); }

WheelOdometry Measure(const RobotDrive& drive, const SynthesizeCeilingOptions& options) {
  return DriveWheels(drive, options, DrawWheelBiases(options));
}

double Distance_m(const WheelOdometry& odometry) {
  double length_m = 0;
  for (std::size_t i = 1; i < odometry.Samples().size(); ++i) {
    length_m += (odometry.Samples()[i] - odometry.Samples()[i - 1]).head<2>().norm();
  }
  return length_m;
}

double Heading_rad(const WheelOdometry& odometry) { return odometry.Samples().back()[2]; }

// Root mean square over seeds of the difference to what is expected.
double Sigma(SynthesizeCeilingOptions options,
             const std::function<double(const WheelOdometry&)>& measure,
             double expected) {
  const RobotDrive drive = Straight();
  double sum = 0;
  for (int seed = 1; seed <= kNumSeeds; ++seed) {
    options.noise_seed = seed;
    const double error = measure(Measure(drive, options)) - expected;
    sum += error * error;
  }
  return std::sqrt(sum / kNumSeeds);
}

// A sigma estimated from 400 draws is off by 3.5 %; 12 % are over three sigmas.
constexpr double kTolerance = 0.12;

TEST(CeilingWheels, WithoutNoiseTheyMeasureTheTruth) {
  const RobotDrive drive = DriveCeilingLegs(PlanCeilingOffice(1).legs, {});
  const WheelOdometry odometry = Measure(drive, Exact());
  const Rigid3 start = RobotPose(drive.At(0));
  for (std::size_t i = 0; i < odometry.Samples().size(); ++i) {
    const RoutePoint truth = drive.At(odometry.TimeOf_s(i));
    const Eigen::Vector3d in_start = start.Inverse() * RobotPose(truth).translation;
    ASSERT_LT((odometry.Samples()[i].head<2>() - in_start.head<2>()).norm(), 1e-9);
    ASSERT_NEAR(odometry.Samples()[i][2], truth.heading_rad - drive.At(0).heading_rad, 1e-9);
  }
}

TEST(CeilingWheels, DistanceNoiseGrowsWithTheRootOfTheDistance) {
  SynthesizeCeilingOptions options = Exact();
  options.wheels.distance_noise_m = 0.02;
  const double expected = 0.02 * std::sqrt(kLength_m);
  EXPECT_NEAR(Sigma(options, Distance_m, kLength_m) / expected, 1, kTolerance);
}

TEST(CeilingWheels, HeadingNoiseGrowsWithTheRootOfTheDistance) {
  SynthesizeCeilingOptions options = Exact();
  options.wheels.heading_noise_rad_per_root_m = 0.0175;
  const double expected = 0.0175 * std::sqrt(kLength_m);
  EXPECT_NEAR(Sigma(options, Heading_rad, 0) / expected, 1, kTolerance);
}

TEST(CeilingWheels, BiasesAreDrawnWithTheirSigmas) {
  SynthesizeCeilingOptions options = Exact();
  options.scale_bias_sigma = 0.005;
  options.heading_bias_sigma_rad_per_m = 0.002;
  EXPECT_NEAR(Sigma(options, Heading_rad, 0) / (0.002 * kLength_m), 1, kTolerance);
  EXPECT_NEAR(Sigma(options, Distance_m, kLength_m) / (0.005 * kLength_m), 1, kTolerance);
}

TEST(CeilingWheels, SlipReportsMoreThanTheRobotDrives) {
  SynthesizeCeilingOptions options = Exact();
  const RobotDrive drive = Straight();
  const double driven_m = Distance_m(Measure(drive, options));
  EXPECT_NEAR(driven_m, kLength_m, 1e-3);  // the last sample is before the end
  options.slip.at_s = 5.03;                // within a step of the odometry
  options.slip.duration_s = 2;
  options.slip.ratio = 0.5;
  const WheelOdometry odometry = Measure(drive, options);
  const double slipped_m = 2 * options.route.speed_m_per_s;
  EXPECT_NEAR(Distance_m(odometry), driven_m + 0.5 * slipped_m, 1e-6);
  EXPECT_NEAR(odometry.At(5)[0], drive.At(5).position.x(), 1e-9);
}

}  // namespace nightmap::ceiling_wheels_test
