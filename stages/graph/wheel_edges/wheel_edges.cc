// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/wheel_edges/wheel_edges.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "pipeline/base/input_error.h"
#include "pipeline/recording/choose_signal.h"

namespace nightmap {
namespace {

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

WheelEdgesResult RunWheelEdges(const WheelEdgesOptions& options, const WheelEdgesInput& input) {
  const Signal& wheels = ChooseOdometry(input.odometry, options.sensor, "wheel_edges.sensor");
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
