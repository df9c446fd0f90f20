// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_adjust/ceiling_adjust.h"

#include <algorithm>

#include "pipeline/base/input_error.h"
#include "tests/stages/ceiling/ceiling_ekf/simulated_drive.h"
#include "tests/test_data.h"

namespace nightmap::ceiling_adjust_test {

struct Case {
  SimulatedDrive drive;
  CeilingAdjustInput input;
};

// A drive with what the filter makes of it.
Case Filtered(const DriveOptions& options) {
  Case made{Simulate(options), {}};
  Progress progress("ceiling_ekf", false);
  made.input.map = RunCeilingEkf({}, made.drive.input, progress).map;
  made.input.tracks = made.drive.input.tracks;
  made.input.camera = made.drive.input.camera;
  made.input.odometry = made.drive.input.odometry;
  for (const CeilingFrame& frame : made.input.map.frames) {
    made.input.trajectory.push_back({frame.time_ns, frame.map_from_robot.ToRigid3()});
  }
  return made;
}

CeilingAdjustResult Adjust(const CeilingAdjustInput& input,
                           const CeilingAdjustOptions& options = {}) {
  Progress progress("ceiling_adjust", false);
  return RunCeilingAdjust(options, input, progress);
}

// Root mean square of what is left after the map is scaled to the way's length.
double ShapeError_m(const CeilingMap& map, const std::vector<Rigid2>& truth) {
  double dot = 0, square = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    dot += map.frames[i].map_from_robot.translation.dot(truth[i].translation);
    square += map.frames[i].map_from_robot.translation.squaredNorm();
  }
  double sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    sum += (dot / square * map.frames[i].map_from_robot.translation - truth[i].translation)
               .squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

double Error_m(const CeilingMap& map, const std::vector<Rigid2>& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    sum += (map.frames[i].map_from_robot.translation - truth[i].translation).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(truth.size()));
}

TEST(CeilingAdjust, IsMoreAccurateThanTheFilter) {
  for (const std::uint64_t seed : AllAtNight<std::uint64_t>({1, 2, 3})) {
    DriveOptions options;
    options.seed = seed;
    const Case made = Filtered(options);
    const CeilingAdjustResult result = Adjust(made.input);
    EXPECT_TRUE(result.solution.has_converged);
    EXPECT_LT(ShapeError_m(result.map, made.drive.truth),
              0.7 * ShapeError_m(made.input.map, made.drive.truth))
        << seed;
    EXPECT_LT(ShapeError_m(result.map, made.drive.truth), 0.02) << seed;
    EXPECT_NEAR(result.mounting[0], options.tilt_rad.x(), 0.002);
    EXPECT_NEAR(result.mounting[1], options.tilt_rad.y(), 0.002);
    EXPECT_NEAR(result.wheels.y(), options.heading_error_rad_per_m, 0.004);
  }
}

// As after a loop that the filter closed late: all sightings are far off at first.
TEST(CeilingAdjust, AWayThatIsBentComesOutTheSame) {
  Case made = Filtered({});
  const CeilingMap straight = Adjust(made.input).map;
  std::vector<StampedPose>& poses = made.input.trajectory;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(poses.size());
    poses[i].pose = Rigid2{0.15 * share, {0, 0}}.ToRigid3() * poses[i].pose;
  }
  const CeilingAdjustResult bent = Adjust(made.input);
  std::vector<Rigid2> expected;
  for (const CeilingFrame& frame : straight.frames) expected.push_back(frame.map_from_robot);
  EXPECT_LT(Error_m(bent.map, expected), 3e-3);
  EXPECT_TRUE(bent.solution.has_converged);
}

TEST(CeilingAdjust, AKnownHeightTellsTheSize) {
  DriveOptions drive;
  drive.scale_error = 0.02;
  const Case made = Filtered(drive);
  CeilingAdjustOptions options;
  options.ceiling_height_m = 2.6;
  options.noise.scale_sigma = 0.03;
  const CeilingAdjustResult result = Adjust(made.input, options);
  EXPECT_NEAR(result.wheels.x(), drive.scale_error, 0.004);
  EXPECT_NEAR(result.level_m, 2.6, 0.005);
  EXPECT_LT(Error_m(result.map, made.drive.truth), 0.05);
  EXPECT_GT(Error_m(Adjust(made.input).map, made.drive.truth), 0.1);
}

// The noise of the wheels must not pull the map small, nor large.
TEST(CeilingAdjust, TheSizeIsThatOfTheWheels) {
  DriveOptions drive;
  drive.scale_error = 0;
  const CeilingAdjustResult result = Adjust(Filtered(drive).input);
  EXPECT_NEAR(result.wheels.x(), 0, 1e-3);
  EXPECT_NEAR(result.level_m, 2.6, 0.02);
}

TEST(CeilingAdjust, FindsACameraThatIsMountedElsewhere) {
  DriveOptions drive;
  drive.path_m = 30;
  Case made = Filtered(drive);
  made.input.camera.robot_from_camera.translation.x() -= 0.05;
  const Eigen::AngleAxisd turn(-0.02, Eigen::Vector3d::UnitZ());
  made.input.camera.robot_from_camera.rotation = Eigen::Quaterniond(turn);
  const CeilingAdjustResult result = Adjust(made.input);
  EXPECT_NEAR(result.mounting[2], 0.02, 0.004);
  EXPECT_NEAR(result.mounting[3], 0.05, 0.02);
}

TEST(CeilingAdjust, SlippingWheelsMoveNothing) {
  DriveOptions drive;
  drive.slip_from_s = 20;
  drive.slip_to_s = 22;
  const Case made = Filtered(drive);
  EXPECT_LT(ShapeError_m(Adjust(made.input).map, made.drive.truth), 0.03);
}

TEST(CeilingAdjust, FramesWithoutKeyframeMoveAlong) {
  DriveOptions drive;
  drive.path_m = 30;
  const Case made = Filtered(drive);
  CeilingAdjustOptions options;
  options.keyframe_distance_m = 0.4;
  const CeilingAdjustResult result = Adjust(made.input, options);
  EXPECT_LT(result.num_keyframes, static_cast<int>(made.drive.truth.size()) / 3);
  EXPECT_LT(ShapeError_m(result.map, made.drive.truth), 0.02);
  for (std::size_t i = 1; i < result.map.frames.size(); ++i) {
    const Rigid2 moved =
        result.map.frames[i - 1].map_from_robot.Inverse() * result.map.frames[i].map_from_robot;
    EXPECT_LT(moved.translation.norm(), 0.12);
  }
}

TEST(CeilingAdjust, SaysWhatDoesNotBelongTogether) {
  DriveOptions drive;
  drive.path_m = 6;
  Case made = Filtered(drive);
  made.input.trajectory.pop_back();
  EXPECT_THROW(Adjust(made.input), InputError);
  made = Filtered(drive);
  made.input.map.landmarks.clear();
  made.input.map.met_again.clear();
  EXPECT_THROW(Adjust(made.input), InputError);
}

}  // namespace nightmap::ceiling_adjust_test
