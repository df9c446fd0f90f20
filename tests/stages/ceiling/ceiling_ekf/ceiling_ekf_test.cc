// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/ceiling_ekf.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "pipeline/base/input_error.h"

#include "pipeline/ceiling/planar_pose.h"
#include "tests/stages/ceiling/ceiling_ekf/simulated_drive.h"
#include "tests/test_data.h"

namespace nightmap::ceiling_ekf_test {

struct Errors {
  double position_rmse_m = 0;
  double heading_rmse_rad = 0;
  double wheels_rmse_m = 0;
  double consistent_ratio = 0;  // frames whose NEES is within its 95 % bounds
  double landmark_median_m = 0;
};

double Rmse(const std::vector<Rigid2>& poses, const std::vector<Rigid2>& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    sum += (poses[i].translation - truth[i].translation).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(poses.size()));
}

Errors Compare(const CeilingEkfResult& result, const SimulatedDrive& drive) {
  Errors errors;
  std::vector<Rigid2> poses;
  double heading = 0;
  int num_consistent = 0;
  for (std::size_t i = 0; i < result.map.frames.size(); ++i) {
    const CeilingFrame& frame = result.map.frames[i];
    poses.push_back(frame.map_from_robot);
    heading +=
        std::pow(WrapAngle_rad(frame.map_from_robot.heading_rad - drive.truth[i].heading_rad), 2);
    Eigen::Vector3d off = ToVector(frame.map_from_robot_then) - ToVector(drive.truth[i]);
    off.z() = WrapAngle_rad(off.z());
    const double nees = off.dot(frame.covariance.llt().solve(off));
    num_consistent += nees > 0.216 && nees < 9.348;
  }
  const auto num = static_cast<double>(poses.size());
  errors.position_rmse_m = Rmse(poses, drive.truth);
  errors.heading_rmse_rad = std::sqrt(heading / num);
  errors.wheels_rmse_m = Rmse(drive.wheels, drive.truth);
  errors.consistent_ratio = num_consistent / num;
  std::vector<double> off_m;
  for (const CeilingLandmark& landmark : result.map.landmarks) {
    off_m.push_back((landmark.position_m - drive.points.at(landmark.track_id)).norm());
  }
  if (!off_m.empty()) {
    std::ranges::nth_element(off_m, off_m.begin() + static_cast<std::ptrdiff_t>(off_m.size() / 2));
    errors.landmark_median_m = off_m[off_m.size() / 2];
  }
  return errors;
}

CeilingEkfResult Map(const SimulatedDrive& drive, const CeilingEkfOptions& options = {}) {
  Progress progress("ceiling_ekf", false);
  return RunCeilingEkf(options, drive.input, progress);
}

double SmallestEigenvalue(const Eigen::Matrix3d& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix).eigenvalues().minCoeff();
}

TEST(CeilingEkf, DrivesALoopAndKnowsHowWell) {
  std::vector<double> consistent;
  for (const std::uint64_t seed : AllAtNight<std::uint64_t>({1, 2, 3})) {
    DriveOptions options;
    options.seed = seed;
    const SimulatedDrive drive = Simulate(options);
    const CeilingEkfResult result = Map(drive);
    const Errors errors = Compare(result, drive);
    ASSERT_EQ(result.map.frames.size(), drive.truth.size());
    EXPECT_LT(errors.position_rmse_m, 0.15) << seed;
    EXPECT_LT(errors.heading_rmse_rad, 0.005) << seed;
    EXPECT_LT(errors.landmark_median_m, 0.15) << seed;
    EXPECT_GE(result.map.loops.size(), 1U) << seed;
    EXPECT_EQ(result.num_slipped, 0) << seed;
    EXPECT_NEAR(result.heading_error_rad_per_m, 0.002, 0.004) << seed;
    EXPECT_LT((result.mounting_tilt_rad - options.tilt_rad).norm(), 0.001) << seed;
    consistent.push_back(errors.consistent_ratio);
    for (const CeilingFrame& frame : result.map.frames) {
      ASSERT_GT(SmallestEigenvalue(frame.covariance), 0);
    }
    for (const CeilingLandmark& landmark : result.map.landmarks) {
      ASSERT_GT(SmallestEigenvalue(landmark.covariance_m2), 0);
    }
  }
  std::ranges::sort(consistent);
  EXPECT_GT(consistent[consistent.size() / 2], 0.85);
}

CeilingEkfOptions Published() {
  CeilingEkfOptions published;
  published.keeper.initial_depth = "published";
  return published;
}

TEST(CeilingEkf, WithoutNoiseItIsExact) {
  DriveOptions options;
  options.pixel_noise_px = options.distance_noise_m = options.heading_noise_rad = 0;
  options.scale_error = options.heading_error_rad_per_m = options.vibration_rad = 0;
  options.tilt_rad.setZero();
  options.path_m = 10;
  const SimulatedDrive drive = Simulate(options);
  for (const CeilingEkfOptions& depth : {CeilingEkfOptions(), Published()}) {
    const Errors errors = Compare(Map(drive, depth), drive);
    EXPECT_LT(errors.position_rmse_m, 1e-3) << depth.keeper.initial_depth;
    EXPECT_LT(errors.heading_rmse_rad, 1e-4) << depth.keeper.initial_depth;
    EXPECT_LT(errors.landmark_median_m, 2e-3) << depth.keeper.initial_depth;
  }
}

TEST(CeilingEkf, WithThePublishedDepthItDrivesALoopToo) {
  const SimulatedDrive drive = Simulate({});
  const Errors errors = Compare(Map(drive, Published()), drive);
  EXPECT_LT(errors.position_rmse_m, errors.wheels_rmse_m / 2);
}

TEST(CeilingEkf, BridgesABlankCeiling) {
  DriveOptions options;
  options.blank_from_m = 2;
  options.blank_to_m = 10;
  const SimulatedDrive drive = Simulate(options);
  const CeilingEkfResult result = Map(drive);
  const Errors errors = Compare(result, drive);
  EXPECT_GT(result.num_blind, 30);
  EXPECT_GE(result.map.loops.size(), 1U);
  EXPECT_LT(errors.position_rmse_m, 0.2);
  EXPECT_LT(errors.position_rmse_m, errors.wheels_rmse_m / 3);
}

TEST(CeilingEkf, TilesThatLookAlikeCloseNoWrongLoop) {
  for (const std::uint64_t seed : {1, 2}) {
    DriveOptions options;
    options.seed = seed;
    options.tiles = true;
    const SimulatedDrive drive = Simulate(options);
    const CeilingEkfResult result = Map(drive);
    const Errors errors = Compare(result, drive);
    EXPECT_LT(errors.position_rmse_m, 0.2) << seed;
    for (const CeilingLoop& loop : result.map.loops) {  // of places that have a ceiling in common
      const auto place = [&](int anchor) {
        return result.map.anchors[static_cast<std::size_t>(anchor)].map_from_anchor.translation;
      };
      EXPECT_LT((place(loop.now) - place(loop.then)).norm(), 6) << seed;
    }
    for (const CeilingFrame& frame : result.map.frames) {
      const double variance_m2 = frame.covariance(0, 0) + frame.covariance(1, 1);
      ASSERT_LT(variance_m2, 0.3 * 0.3) << seed;
    }
  }
}

TEST(CeilingEkf, BelievesThePictureWhereWheelsSlip) {
  DriveOptions options;
  options.path_m = 20;
  const Errors without = Compare(Map(Simulate(options)), Simulate(options));
  options.slip_from_s = 15;
  options.slip_to_s = 17;
  const SimulatedDrive drive = Simulate(options);
  const CeilingEkfResult result = Map(drive);
  const Errors errors = Compare(result, drive);
  EXPECT_GT(errors.wheels_rmse_m, 0.2);
  EXPECT_LT(errors.position_rmse_m, without.position_rmse_m + 0.05);
  EXPECT_GT(result.num_slipped, 5);
  EXPECT_LT(result.num_slipped, 30);  // frames of 2 s, and a few more
}

TEST(CeilingEkf, GoesOnWhereTheOdometryHasAGap) {
  DriveOptions options;
  options.path_m = 20;
  SimulatedDrive drive = Simulate(options);
  std::vector<SignalSample>& samples = drive.input.odometry[0].samples;
  samples.erase(samples.begin() + 150, samples.begin() + 180);
  const CeilingEkfResult result = Map(drive);
  EXPECT_EQ(result.num_without_odometry, 31);
  EXPECT_LT(Compare(result, drive).position_rmse_m, 0.15);
  CeilingEkfOptions strict;
  strict.max_missing_ratio = 0.05;
  try {
    Map(drive, strict);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("odometry: sensor 'wheels' says nothing of 31"));
  }
}

TEST(CeilingEkf, PicturesMayBeMissing) {
  DriveOptions options;
  options.path_m = 20;
  SimulatedDrive drive = Simulate(options);
  for (std::size_t i = 150; i < 160; ++i) drive.input.tracks.frames[i].sightings.clear();
  const CeilingEkfResult result = Map(drive);
  EXPECT_LT(Compare(result, drive).position_rmse_m, 0.15);
  EXPECT_GT(result.num_blind, 9);
}

TEST(CeilingEkf, ARobotThatStandsStaysThere) {
  DriveOptions options;
  options.path_m = 6;
  SimulatedDrive drive = Simulate(options);
  // The last frame again and again.
  const TrackedFrame last = drive.input.tracks.frames.back();
  const SignalSample sample = drive.input.odometry[0].samples.back();
  for (int i = 1; i <= 300; ++i) {
    drive.input.tracks.frames.push_back(last);
    drive.input.tracks.frames.back().time_ns += 100'000'000LL * i;
    drive.input.odometry[0].samples.push_back(
        {sample.time_ns + 100'000'000LL * i, sample.value, {}});
    drive.truth.push_back(drive.truth.back());
    drive.wheels.push_back(drive.wheels.back());
  }
  const CeilingEkfResult result = Map(drive);
  const CeilingFrame& before = result.map.frames[result.map.frames.size() - 301];
  const CeilingFrame& after = result.map.frames.back();
  EXPECT_LT((before.map_from_robot_then.translation - after.map_from_robot_then.translation).norm(),
            0.02);
  EXPECT_GT(SmallestEigenvalue(after.covariance), 0);
}

// Several laps; the map does not grow with them, and stays exact about what it knows.
TEST(CeilingEkf, CovariancesArePositiveDefiniteThroughTenThousandFrames) {
  DriveOptions options;
  options.side_m = 5;
  options.points_per_m2 = 1.5;
  options.rate_hz = 30;
  options.path_m = 201;
  const SimulatedDrive drive = Simulate(options);
  CeilingEkfOptions few;
  few.keeper.max_landmarks = 10;
  const CeilingEkfResult result = Map(drive, few);
  ASSERT_GE(result.map.frames.size(), 10'000U);
  EXPECT_GT(result.map.loops.size(), 5U);
  EXPECT_LT(Compare(result, drive).position_rmse_m, 0.15);
  for (const CeilingFrame& frame : result.map.frames) {
    ASSERT_EQ(frame.covariance, frame.covariance.transpose());
    ASSERT_GT(SmallestEigenvalue(frame.covariance), 0);
  }
}

TEST(CeilingEkf, OneRunIsLikeAnother) {
  DriveOptions options;
  options.side_m = 5;
  options.path_m = 27;
  const SimulatedDrive drive = Simulate(options);
  for (const CeilingEkfOptions& depth : {CeilingEkfOptions(), Published()}) {
    const CeilingEkfResult a = Map(drive, depth), b = Map(drive, depth);
    ASSERT_EQ(a.map.landmarks.size(), b.map.landmarks.size());
    EXPECT_FALSE(a.map.loops.empty());
    for (std::size_t i = 0; i < a.map.landmarks.size(); ++i) {
      EXPECT_EQ(a.map.landmarks[i].position_m, b.map.landmarks[i].position_m);
    }
  }
}

TEST(CeilingEkf, RefusesASiteWithoutWheels) {
  DriveOptions options;
  options.path_m = 1;
  SimulatedDrive drive = Simulate(options);
  CeilingEkfOptions named;
  named.odometry.sensor = "gyro";
  EXPECT_THROW(Map(drive, named), UsageError);
  drive.input.odometry.clear();
  EXPECT_THROW(Map(drive), InputError);
}

}  // namespace nightmap::ceiling_ekf_test
