// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/scan_adjust.h"

#include "pipeline/base/input_error.h"
#include "pipeline/io/trajectory_io.h"
#include "tests/laser_building.h"
#include "tests/test_data.h"

namespace nightmap::scan_adjust_test {

constexpr double kDegree_rad = std::numbers::pi / 180;

const Building kRoom{{{-5, -4}, {5, 4}}, {{-1, -0.6}, {1.2, 0.8}}, {{3.9, -4}, {5, -3.2}}};

const Building kRing{{{-8, -6}, {8, 6}},
                     {{-5, -3}, {5, 3}},
                     {{-8, -2}, {-7.5, -0.7}},
                     {{-3.3, 5.6}, {-1, 6}},
                     {{7.6, 1.5}, {8, 3}},
                     {{2.1, -6}, {2.9, -5.5}}};

std::vector<Rigid2> Noisy(const std::vector<Rigid2>& poses,
                          double sigma_m,
                          double sigma_rad,
                          std::uint64_t seed) {
  Random random(seed);
  std::vector<Rigid2> noisy = poses;
  for (std::size_t i = 1; i < poses.size(); ++i) {  // the first one is where the graph begins
    noisy[i].translation += sigma_m * Eigen::Vector2d(random.Gaussian(), random.Gaussian());
    noisy[i].heading_rad += sigma_rad * random.Gaussian();
  }
  return noisy;
}

// True poses, and keyscans that are off by 2 cm and 1 deg. The odometry's errors add up.
struct Drive {
  std::vector<Rigid2> truth;
  ScanAdjustInput input;

  Drive(const Building& building, std::vector<Rigid2> poses) : truth(std::move(poses)) {
    constexpr double kSigma_m = 0.01, kSigma_rad = 0.3 * kDegree_rad;
    Random random(5);
    std::vector<Rigid2> wheels{truth[0]};
    for (std::size_t i = 1; i < truth.size(); ++i) {
      const Rigid2 error{kSigma_rad * random.Gaussian(),
                         {kSigma_m * random.Gaussian(), kSigma_m * random.Gaussian()}};
      wheels.push_back(wheels.back() * (truth[i - 1].Inverse() * truth[i]) * error);
    }
    input.scans = {ScansAt(building, truth, 0.01)};
    input.keyscans = KeyscansAt(Noisy(truth, 0.02, kDegree_rad, 4));
    input.odometry = OdometryOf(wheels, kSigma_m, kSigma_rad);
  }
};

Drive InARoom() { return {kRoom, DriveAround({3, 2.4}, 0.8, 0.35, 1)}; }

ScanAdjustResult Adjust(const ScanAdjustInput& input,
                        const ScanAdjustOptions& options = {},
                        int num_threads = 2) {
  Progress progress("scan_adjust", false);
  return RunScanAdjust(options, input, progress, num_threads);
}

struct Errors {
  double rms_m = 0, rms_rad = 0, max_m = 0, max_rad = 0;
};

Errors ErrorsOf(const std::vector<StampedPose>& keyscans, const std::vector<Rigid2>& truth) {
  Errors errors;
  const auto num = static_cast<double>(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const Rigid2 found = ToRigid2(keyscans[0].pose).Inverse() * ToRigid2(keyscans[i].pose);
    const Rigid2 error = (truth[0].Inverse() * truth[i]).Inverse() * found;
    const double off_m = error.translation.norm(), off_rad = std::abs(error.heading_rad);
    errors.rms_m += off_m * off_m / num;
    errors.rms_rad += off_rad * off_rad / num;
    errors.max_m = std::max(errors.max_m, off_m);
    errors.max_rad = std::max(errors.max_rad, off_rad);
  }
  errors.rms_m = std::sqrt(errors.rms_m);
  errors.rms_rad = std::sqrt(errors.rms_rad);
  return errors;
}

TEST(ScanAdjust, PosesOfARoomBecomeThoseThatItsWallsTell) {
  const Drive drive = InARoom();
  EXPECT_GT(ErrorsOf(drive.input.keyscans, drive.truth).rms_m, 0.02);
  const ScanAdjustResult result = Adjust(drive.input);
  ASSERT_EQ(result.keyscans.size(), drive.truth.size());
  const Errors errors = ErrorsOf(result.keyscans, drive.truth);
  EXPECT_LT(errors.max_m, 0.005);
  EXPECT_LT(errors.max_rad, 0.15 * kDegree_rad);
  EXPECT_GT(result.num_pairs, 4 * drive.truth.size());
  EXPECT_GT(result.num_matches, 50 * drive.truth.size());
  EXPECT_LT(result.rms_m, 0.02);
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    EXPECT_EQ(result.keyscans[i].time_ns, drive.input.keyscans[i].time_ns);
  }
}

TEST(ScanAdjust, PosesOfMoreThanALapAroundARingToo) {
  const Drive drive(kRing, DriveAround({6.5, 4.5}, 1, 0.4, 1.6));
  const Errors errors = ErrorsOf(Adjust(drive.input).keyscans, drive.truth);
  EXPECT_LT(errors.rms_m, 0.005);
  EXPECT_LT(errors.rms_rad, 0.15 * kDegree_rad);
}

TEST(ScanAdjust, TheFirstKeyscanStays) {
  const Drive drive = InARoom();
  const Rigid2 before = ToRigid2(drive.input.keyscans[0].pose);
  const Rigid2 after = ToRigid2(Adjust(drive.input).keyscans[0].pose);
  EXPECT_LT((after.translation - before.translation).norm(), 1e-6);
  EXPECT_NEAR(after.heading_rad, before.heading_rad, 1e-6);
}

// Walls along x alone; the ends are out of reach. The poses begin as the odometry says, with noise
// across. The noise of ranges turns the normals of walls a little, so that they pull along x, too:
// less than the odometry's own errors.
TEST(ScanAdjust, AlongACorridorTheOdometryStays) {
  const Building corridor{{{-60, -1.2}, {60, 1.2}}};
  constexpr double kSigma_m = 0.02;
  ScanAdjustOptions options;
  options.max_range_m = 20;
  for (const double noise_m : {0.0, 0.01}) {
    std::vector<Rigid2> truth, wheels, start;
    Random random(6);
    for (int i = 0; i < 40; ++i) {
      truth.push_back({0, {0.25 * i, 0.1}});
      const double along_m =
          i == 0 ? 0 : wheels.back().translation.x() + random.Uniform(0.24, 0.28);
      wheels.push_back({0, {along_m, 0.1}});
      start.push_back({i == 0 ? 0 : 0.01 * random.Gaussian(),
                       {along_m, 0.1 + (i == 0 ? 0 : 0.02 * random.Gaussian())}});
    }
    const ScanAdjustInput input{
        {ScansAt(corridor, truth, noise_m)}, KeyscansAt(start), OdometryOf(wheels, kSigma_m, 0.01)};
    const ScanAdjustResult result = Adjust(input, options);
    for (std::size_t i = 1; i < truth.size(); ++i) {
      SCOPED_TRACE(testing::Message() << noise_m << ", " << i);
      const Rigid2 found = ToRigid2(result.keyscans[i].pose);
      const Rigid2 last = ToRigid2(result.keyscans[i - 1].pose);
      const double off_m = found.translation.x() - wheels[i].translation.x();
      EXPECT_LT(std::abs(off_m), noise_m == 0 ? 0.001 : kSigma_m * std::sqrt(i));
      EXPECT_NEAR(found.translation.x() - last.translation.x(),
                  wheels[i].translation.x() - wheels[i - 1].translation.x(),
                  noise_m == 0 ? 0.001 : kSigma_m);
      EXPECT_NEAR(found.translation.y(), 0.1, 0.006);
      EXPECT_NEAR(found.heading_rad, 0, 0.15 * kDegree_rad);
    }
  }
}

TEST(ScanAdjust, WithoutRoundsNothingMoves) {
  const Drive drive = InARoom();
  ScanAdjustOptions options;
  options.num_rounds = 0;
  const ScanAdjustResult result = Adjust(drive.input, options);
  ASSERT_EQ(result.keyscans.size(), drive.input.keyscans.size());
  for (std::size_t i = 0; i < result.keyscans.size(); ++i) {
    EXPECT_EQ(result.keyscans[i].time_ns, drive.input.keyscans[i].time_ns);
    EXPECT_TRUE(
        result.keyscans[i].pose.Matrix().isApprox(drive.input.keyscans[i].pose.Matrix(), 1e-12));
  }
  EXPECT_GT(result.num_matches, 0U);
  EXPECT_GT(result.rms_m, Adjust(drive.input).rms_m);
}

TEST(ScanAdjust, WhereTheGraphLiesDoesNotMatter) {
  const Drive drive = InARoom();
  ScanAdjustInput moved = drive.input;
  const Rigid2 move{2.5, {30, -70}};
  for (StampedPose& keyscan : moved.keyscans) {
    keyscan.pose = (move * ToRigid2(keyscan.pose)).ToRigid3();
  }
  const auto here = Adjust(drive.input).keyscans, there = Adjust(moved).keyscans;
  for (std::size_t i = 0; i < here.size(); ++i) {
    const Rigid2 difference = (move * ToRigid2(here[i].pose)).Inverse() * ToRigid2(there[i].pose);
    EXPECT_LT(difference.translation.norm(), 1e-4) << i;
    EXPECT_LT(std::abs(difference.heading_rad), 1e-4) << i;
  }
}

TEST(ScanAdjust, AnyNumberOfThreadsGivesTheSameBytes) {
  const Drive drive = InARoom();
  const auto text = [&](int num_threads) {
    return TrajectoryToTum(Adjust(drive.input, {}, num_threads).keyscans, "graph_from_robot", 15);
  };
  EXPECT_EQ(text(1), text(4));
}

TEST(ScanAdjust, OneKeyscanOrScansThatHitNothingKeepThePoses) {
  Drive drive = InARoom();
  ScanAdjustInput one = drive.input;
  one.keyscans.resize(1);
  one.odometry.edges.clear();
  EXPECT_TRUE(Adjust(one).keyscans[0].pose.Matrix().isApprox(one.keyscans[0].pose.Matrix(), 1e-12));
  // Without a wall the odometry alone is left.
  for (SignalSample& scan : drive.input.scans[0].samples) {
    std::ranges::fill(scan.ranges_m, 80.0F);
  }
  const ScanAdjustResult blind = Adjust(drive.input);
  EXPECT_EQ(blind.num_matches, 0U);
  EXPECT_EQ(blind.rms_m, 0);
  for (std::size_t i = 0; i + 1 < blind.keyscans.size(); ++i) {
    const Rigid2 next_from_this =
        ToRigid2(blind.keyscans[i + 1].pose).Inverse() * ToRigid2(blind.keyscans[i].pose);
    const Rigid2 wheels = ToRigid2(drive.input.odometry.edges[i].target_from_source);
    EXPECT_LT((next_from_this.translation - wheels.translation).norm(), 1e-4) << i;
  }
}

TEST(ScanAdjust, InputsThatDoNotFitAreRefused) {
  const ScanAdjustInput good = InARoom().input;
  ScanAdjustInput input = good;
  input.odometry.edges.pop_back();
  NIGHTMAP_EXPECT_ERROR(InputError, Adjust(input), "odometry, keyframes: their keyscans differ");
  input = good;
  std::swap(input.odometry.edges[0], input.odometry.edges[1]);
  NIGHTMAP_EXPECT_ERROR(InputError, Adjust(input), "their keyscans differ");
  input = good;
  input.keyscans.clear();
  input.odometry.edges.clear();
  NIGHTMAP_EXPECT_ERROR(InputError, Adjust(input), "their keyscans differ");
  input = good;
  input.scans[0].samples.pop_back();
  NIGHTMAP_EXPECT_ERROR(
      InputError, Adjust(input), "keyframes, scans: there is a keyscan and no scan at");
  input = good;
  input.scans.clear();
  NIGHTMAP_EXPECT_ERROR(InputError, Adjust(input), "no sensor of the site scans");
  ScanAdjustOptions options;
  options.scan_sensor = "rear";
  NIGHTMAP_EXPECT_ERROR(
      UsageError,
      Adjust(good, options),
      "scan_adjust.scan_sensor is 'rear': choose one of the sensors that scan: laser");
}

}  // namespace nightmap::scan_adjust_test
