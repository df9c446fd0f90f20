// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/map_frame.h"

#include <algorithm>

#include "pipeline/dense/rgbd_keyframes.h"
#include "stages/dense/map_frame/choose_floor.h"
#include "stages/dense/map_frame/find_map_frame.h"

namespace nightmap {
namespace {

// A camera without a pose on the robot: z of the camera is x of the robot, -y is z.
const Rigid3& UprightCamera() {
  static const Rigid3 robot_from_camera{{0.5, -0.5, 0.5, -0.5}, Eigen::Vector3d::Zero()};
  return robot_from_camera;
}

bool IsMountStated(const RgbdCamera& camera) {
  return AngleBetween_rad(camera.robot_from_camera, Rigid3()) > 0;
}

// given_from_robot of the keyframes. `unstated`: robot_from_camera where no site config has it.
std::vector<StampedPose> RobotPoses(const std::vector<Keyframe>& keyframes,
                                    const std::vector<RgbdCamera>& cameras,
                                    const Rigid3& unstated) {
  std::vector<StampedPose> poses;
  for (const Keyframe& keyframe : keyframes) {
    const auto& camera = cameras[static_cast<std::size_t>(keyframe.frame.camera_idx)];
    const Rigid3& robot_from_camera = IsMountStated(camera) ? camera.robot_from_camera : unstated;
    poses.push_back(
        {keyframe.frame.time_ns, keyframe.map_from_camera * robot_from_camera.Inverse()});
  }
  return poses;
}

UpInput UpInputOf(const MapFrameInput& input, const std::vector<Keyframe>& keyframes) {
  UpInput up;
  for (const StampedPose& stamped : RobotPoses(keyframes, input.cameras, UprightCamera())) {
    up.given_from_robots.push_back(stamped.pose);
  }
  up.is_mount_stated = std::ranges::any_of(input.cameras, IsMountStated);
  if (!input.accelerometer.empty()) {
    up.measured_in_given =
        UpFromAccelerometer(input.accelerometer, RobotPoses(keyframes, input.cameras, Rigid3()));
  }
  return up;
}

}  // namespace

MapFrame RunMapFrame(const MapFrameOptions& options, const MapFrameInput& input, int num_threads) {
  std::vector<Rigid3> given_from_cameras;
  for (const StampedPose& keyframe : input.keyframes) given_from_cameras.push_back(keyframe.pose);
  if (options.source == "given") {
    MapFrame frame;
    frame.gravity_source = frame.floor_source = MapFrame::kGiven;
    frame.camera_height_m = MedianHeight_m(given_from_cameras, Eigen::Vector3d::UnitZ());
    return frame;
  }
  const auto keyframes = SelectKeyframes(input.frames, input.cameras, input.keyframes, 1);
  const auto patches = SampleKeyframes(options, input, keyframes, num_threads);
  return FindMapFrame(options, patches, given_from_cameras, UpInputOf(input, keyframes));
}

}  // namespace nightmap
