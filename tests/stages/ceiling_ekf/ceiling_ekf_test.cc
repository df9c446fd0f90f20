// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling_ekf/ceiling_ekf.h"

#include <Eigen/Cholesky>

#include "stages/ceiling_ekf/planar_pose.h"
#include "tests/stages/ceiling_ekf/simulated_drive.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

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
    heading += std::pow(
        WrapAngle_rad(frame.map_from_robot.heading_rad - drive.truth[i].heading_rad), 2);
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

TEST(CeilingEkf, DrivesALoop) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    DriveOptions options;
    options.seed = seed;
    const SimulatedDrive drive = Simulate(options);
    const CeilingEkfResult result = Map(drive);
    const Errors errors = Compare(result, drive);
    std::cout << seed << " rmse " << errors.position_rmse_m << " heading " << errors.heading_rmse_rad
              << " wheels " << errors.wheels_rmse_m << " nees " << errors.consistent_ratio
              << " landmarks " << errors.landmark_median_m << " n " << result.map.landmarks.size()
              << " loops " << result.map.loops.size() << " ambiguous " << result.num_ambiguous
              << " slipped " << result.num_slipped << " scale " << result.wheel_scale_error << " bias "
              << result.heading_error_rad_per_m << " tilt " << result.mounting_tilt_rad.transpose()
              << " inconsistent " << result.counts.num_inconsistent << " weak " << result.counts.num_weak << "\n";
  }
}

}  // namespace
}  // namespace nightmap
