// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/finish_scans.h"

#include <gtest/gtest.h>

#include <numbers>

#include "pipeline/recording/scan_points.h"

namespace nightmap::finish_scans_test {

// Scans of a full circle from -180 deg on, `step_deg` apart (negative: clockwise from 180 on), with
// the range 2 m everywhere.
std::vector<SignalSample> Circle(double step_deg) {
  const double rad = std::numbers::pi / 180;
  const auto num_beams = static_cast<std::size_t>(std::lround(360 / std::abs(step_deg)));
  const double first_deg = step_deg > 0 ? -180 : 180;
  SignalSample scan{1, {first_deg * rad, step_deg * rad, 10}, {}};
  scan.ranges_m.assign(num_beams, 2);
  return {scan, scan};
}

SensorConfig Scanner() {
  SensorConfig sensor;
  sensor.kind = SignalKind::kScan;
  sensor.max_range_m = 10;
  return sensor;
}

// Angles of the beams that are not measured, from -180 on.
std::vector<int> BlindAngles_deg(const SensorConfig& sensor, double step_deg) {
  auto scans = Circle(step_deg);
  FinishScans(sensor, &scans);
  EXPECT_EQ(scans[0].ranges_m, scans[1].ranges_m);
  std::vector<int> angles_deg;
  for (std::size_t i = 0; i < scans[0].ranges_m.size(); ++i) {
    if (scans[0].ranges_m[i] != kNotMeasured_m) continue;
    const double angle_deg = scans[0].value[0] / (std::numbers::pi / 180) + step_deg * double(i);
    angles_deg.push_back(static_cast<int>(std::lround(angle_deg)));
  }
  return angles_deg;
}

TEST(FinishScans, SectorsGoCounterClockwiseFromTheFirstAngleToTheSecond) {
  SensorConfig sensor = Scanner();
  EXPECT_TRUE(BlindAngles_deg(sensor, 45).empty());
  sensor.blind_deg = {-90, 45};
  EXPECT_EQ(BlindAngles_deg(sensor, 45), (std::vector{-90, -45, 0, 45}))
      << "both ends belong to it";
  EXPECT_EQ(BlindAngles_deg(sensor, -45), (std::vector{45, 0, -45, -90}));
  sensor.blind_deg = {44, -91};
  EXPECT_EQ(BlindAngles_deg(sensor, 45), (std::vector{-180, -135, 45, 90, 135}));
  for (const std::vector<double>& behind :
       {std::vector<double>{135, 225}, {135, -135}, {-225, -135}, {135, 180, -180, -135}}) {
    sensor.blind_deg = behind;
    EXPECT_EQ(BlindAngles_deg(sensor, 45), (std::vector{-180, -135, 135})) << behind[1];
  }
}

TEST(FinishScans, NearRangesAreOfTheRobotAndNoHitStaysNoHit) {
  SensorConfig sensor = Scanner();
  sensor.min_range_m = 0.5;
  auto scans = Circle(60);
  scans[0].ranges_m = {0, 0.4F, 0.5F, 0.6F, 10, 1e4F};
  FinishScans(sensor, &scans);
  EXPECT_EQ(scans[0].ranges_m, (std::vector<float>{0, kNotMeasured_m, 0.5F, 0.6F, 10, 1e4F}));
}

// Scans whose beams do not all fit in a circle share it before sectors are cut out.
TEST(FinishScans, SectorsAreOfTheAnglesThatBeamsGet) {
  SensorConfig sensor = Scanner();
  sensor.start_angle_deg = -180;
  sensor.angle_step_deg = 90;
  sensor.blind_deg = {-1, 1};
  auto scans = Circle(45);
  for (SignalSample& scan : scans) scan.value[1] = std::numbers::pi / 2;
  FinishScans(sensor, &scans);
  EXPECT_EQ(scans[0].ranges_m, (std::vector<float>{2, 2, 2, 2, kNotMeasured_m, 2, 2, 2}));
}

}  // namespace nightmap::finish_scans_test
