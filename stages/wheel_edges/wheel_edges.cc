// SPDX-License-Identifier: Apache-2.0
#include "stages/wheel_edges/wheel_edges.h"

#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "pipeline/base/input_error.h"

namespace nightmap {
namespace {

const Signal& ChooseSensor(const std::string& sensor, const std::vector<Signal>& odometry) {
  if (odometry.empty()) {
    throw InputError({{"odometry"}},
                     InputError::Remedy::kInText,
                     "no sensor of the site measures odometry; add a [[sensor]] of kind "
                     "\"odometry\" and its [[signal]] to the site config, or map without the "
                     "profile");
  }
  if (sensor.empty() && odometry.size() == 1) return odometry.front();
  const auto found = std::ranges::find(odometry, sensor, &Signal::sensor_id);
  if (found != odometry.end()) return *found;
  std::vector<std::string> ids;
  for (const Signal& signal : odometry) ids.push_back(signal.sensor_id);
  throw UsageError(
      "wheel_edges.sensor is '{}': choose one of the sensors that measure odometry: {}",
      sensor,
      fmt::join(ids, ", "));
}

void WarnOfAxes(const std::vector<RgbdCamera>& cameras, const Signal& wheels) {
  constexpr double kSame_rad = 1e-6;
  for (const RgbdCamera& camera : cameras) {
    const double angle_rad = AngleBetween_rad(camera.robot_from_camera, wheels.robot_from_sensor);
    if (angle_rad > kSame_rad) continue;
    spdlog::warn(
        "camera '{}' has the axes of '{}', so it looks straight up; if it does not, set "
        "robot_from_camera of its [[camera]] in the site config (robot: x forward, z up)",
        camera.camera_id,
        wheels.sensor_id);
  }
}

}  // namespace

void WheelEdgesOptions::Register(OptionList& list) {
  list.Add("sensor", &sensor, "id of the sensor; empty: the only one that measures odometry");
  noise.Register(list);
}

WheelEdgesResult RunWheelEdges(const WheelEdgesOptions& options, const WheelEdgesInput& input) {
  const Signal& wheels = ChooseSensor(options.sensor, input.odometry);
  WarnOfAxes(input.cameras, wheels);
  WheelEdgesResult result{WheelEdges(options.noise, input.frames, input.cameras, wheels)};
  if (result.edges.edges.empty()) {
    throw InputError({{"odometry"}},
                     InputError::Remedy::kInText,
                     "sensor '{}' has no samples around any two consecutive frames; correct "
                     "time_offset_s of its [[signal]] in the site config (`make inspect` shows the "
                     "times), or raise wheel_edges.max_gap_s",
                     wheels.sensor_id);
  }
  for (std::size_t i = 1; i < input.frames.size(); ++i) {
    result.num_motions += input.frames[i - 1].sequence_idx == input.frames[i].sequence_idx;
  }
  return result;
}

}  // namespace nightmap
