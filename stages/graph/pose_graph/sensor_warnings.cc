// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/sensor_warnings.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <numbers>

namespace nightmap {
namespace {

constexpr double kNumSigmas = 4;
constexpr double kDegrees = 180 / std::numbers::pi;

bool IsWrong(const SensorCalibration& calibration, int begin, int end, double threshold) {
  for (int i = begin; i < end; ++i) {
    const double size = std::abs(calibration.value[i]);
    if (size > threshold && size > kNumSigmas * calibration.sigma[i]) return true;
  }
  return false;
}

std::string MountingWarning(const std::string& sensor, const SensorCalibration& calibration) {
  const auto& value = calibration.value;
  const Rigid3 pose = calibration.CorrectedPose();
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Vector4d& q = pose.rotation.coeffs();
  const char* name = calibration.camera_idx ? "robot_from_camera" : "robot_from_sensor";
  return fmt::format(
      "{}: {} seems wrong by ({:.3f}, {:.3f}, {:.3f}) m and ({:.1f}, {:.1f}, {:.1f}) deg: write "
      "{} = [{:.4f}, {:.4f}, {:.4f}, {:.6f}, {:.6f}, {:.6f}, {:.6f}]{}",
      sensor,
      name,
      value[3],
      value[4],
      value[5],
      kDegrees * value[0],
      kDegrees * value[1],
      kDegrees * value[2],
      name,
      t.x(),
      t.y(),
      t.z(),
      q.x(),
      q.y(),
      q.z(),
      q.w(),
      calibration.camera_idx ? ", if robot_from_sensor of the sensor is right" : "");
}

std::string ClockWarning(const std::string& sensor, const SensorCalibration& calibration) {
  const double time_s = calibration.value[kTimeIdx];
  return fmt::format("{}: its clock is {:.3f} s {}: add {:.3f} to time_offset_s of its [[signal]]",
                     sensor,
                     std::abs(time_s),
                     time_s < 0 ? "late" : "early",
                     time_s);
}

}  // namespace

bool IsMountingWrong(const CalibrationWarnings& options, const SensorCalibration& calibration) {
  return IsWrong(calibration, 0, 3, options.min_error_rad) ||
         IsWrong(calibration, 3, 6, options.min_error_m);
}

bool IsClockWrong(const CalibrationWarnings& options, const SensorCalibration& calibration) {
  return IsWrong(calibration, kTimeIdx, kTimeIdx + 1, options.min_error_s);
}

std::vector<std::string> WarningsOf(const CalibrationWarnings& options,
                                    const std::string& sensor,
                                    const SensorCalibration& calibration) {
  std::vector<std::string> warnings;
  if (IsMountingWrong(options, calibration)) {
    warnings.push_back(MountingWarning(sensor, calibration));
  }
  if (IsClockWrong(options, calibration)) warnings.push_back(ClockWarning(sensor, calibration));
  return warnings;
}

void LogWarnings(const std::vector<SensorRecord>& sensors) {
  for (const SensorRecord& sensor : sensors) {
    for (const std::string& warning : sensor.warnings) spdlog::warn("{}", warning);
  }
}

nlohmann::json Summarize(const SensorCalibration& calibration) {
  const char* const names[] = {
      "roll_rad", "pitch_rad", "yaw_rad", "x_m", "y_m", "z_m", "scale", "time_s"};
  nlohmann::json value, sigma;
  for (int i = 0; i < calibration.value.size(); ++i) {
    const bool is_known = calibration.is_observable.at(static_cast<std::size_t>(i));
    const auto shown = [&](double x) { return is_known ? nlohmann::json(x) : nlohmann::json(); };
    value[names[i]] = shown(calibration.value[i]);
    sigma[names[i]] = shown(calibration.sigma[i]);
  }
  return {{"corrects", calibration.camera_idx ? "robot_from_camera" : "robot_from_sensor"},
          {"num_stretches", calibration.num_stretches},
          {"value", value},
          {"sigma", sigma}};
}

}  // namespace nightmap
