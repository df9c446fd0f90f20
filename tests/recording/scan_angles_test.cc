// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/scan_angles.h"

#include <numbers>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::scan_angles_test {

constexpr double kRadPerDeg = std::numbers::pi / 180;

double Step_deg(const SensorConfig& sensor,
                std::size_t num_beams,
                const std::optional<LineAngles>& of_line = {}) {
  return BeamAngles_rad(sensor, num_beams, of_line)[1] / kRadPerDeg;
}

SensorConfig From(double start_angle_deg) {
  SensorConfig sensor;
  sensor.start_angle_deg = start_angle_deg;
  return sensor;
}

TEST(ScanAngles, AHalfCircleIsDividedAsCarmenDoes) {
  for (const auto& [num_beams, step_deg] :
       {std::pair{180, 1.0}, {181, 1.0}, {360, 0.5}, {361, 0.5}, {721, 0.25}, {4, 45.0}}) {
    const SensorConfig sensor;
    EXPECT_NEAR(Step_deg(sensor, static_cast<std::size_t>(num_beams)), step_deg, 1e-12)
        << num_beams;
    EXPECT_NEAR(BeamAngles_rad(sensor, 180)[0], -90 * kRadPerDeg, 1e-12);
  }
}

TEST(ScanAngles, BeamsAreSymmetricAboutXUnlessTheirStepIsStated) {
  EXPECT_NEAR(Step_deg(From(-135), 1081), 0.25, 1e-12);
  EXPECT_NEAR(Step_deg(From(-120), 682), 240.0 / 682, 1e-12);
  for (const std::size_t num_beams : {350u, 360u, 361u}) {  // the last beam is not the first
    EXPECT_NEAR(Step_deg(From(-180), num_beams), 360.0 / static_cast<double>(num_beams), 1e-12);
  }
  SensorConfig stated = From(20);
  stated.angle_step_deg = -3;
  EXPECT_NEAR(Step_deg(stated, 7), -3, 1e-12);
  EXPECT_NEAR(BeamAngles_rad(stated, 7)[0], 20 * kRadPerDeg, 1e-12);
}

TEST(ScanAngles, ALineMayStateThem) {
  const LineAngles angles{-1, 3.141593, 0.01};
  EXPECT_EQ(BeamAngles_rad({}, 7, angles), Eigen::Vector2d(-1, 0.01));
  // Without a step in the line, the field of view there is shared.
  EXPECT_NEAR(Step_deg({}, 361, LineAngles{-1.570796, 3.141593, 0}), 0.5, 1e-6);
  NIGHTMAP_EXPECT_ERROR(
      DataError, BeamAngles_rad({}, 7, LineAngles{}), "write start_angle_deg and angle_step_deg");
}

TEST(ScanAngles, NoScannerSeesMoreThanACircle) {
  SensorConfig sensor = From(-180);
  sensor.angle_step_deg = -1;
  EXPECT_NEAR(Step_deg(sensor, 361), -1, 1e-12);  // 0 and 360 deg
  EXPECT_NEAR(Step_deg(sensor, 365), -360.0 / 365, 1e-12);
  EXPECT_NEAR(Step_deg(sensor, 90), -1, 1e-12);
  NIGHTMAP_EXPECT_ERROR(DataError, Step_deg(sensor, 720), "more than a circle");
}

}  // namespace nightmap::scan_angles_test
