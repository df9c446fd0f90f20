// SPDX-License-Identifier: Apache-2.0
#include "stages/map_frame/map_frame.h"

#include "pipeline/dense/rgbd_keyframes.h"
#include "stages/map_frame/choose_floor.h"
#include "stages/map_frame/find_map_frame.h"

namespace nightmap {
namespace {

// given_from_robot of the keyframes.
std::vector<StampedPose> RobotPoses(const std::vector<Keyframe>& keyframes,
                                    const std::vector<RgbdCamera>& cameras) {
  std::vector<StampedPose> poses;
  for (const Keyframe& keyframe : keyframes) {
    const auto& camera = cameras[static_cast<std::size_t>(keyframe.frame.camera_idx)];
    poses.push_back(
        {keyframe.frame.time_ns, keyframe.map_from_camera * camera.robot_from_camera.Inverse()});
  }
  return poses;
}

}  // namespace

void MapFrameOptions::Register(OptionList& list) {
  list.Add("source",
           &source,
           {"floor", "given"},
           "floor: the map frame has z up and the detected floor at z = 0; given: the map frame is "
           "that of the input trajectory, which has z up already");
  list.Add("floor_num_keyframes",
           &floor_num_keyframes,
           Range(1, 10000),
           "keyframes whose depth is searched for the floor");
  list.Add("floor_max_depth_m", &floor_max_depth_m, Range(0.5, 20), "farther depth is ignored");
  list.Add("floor_max_tilt_rad",
           &floor_max_tilt_rad,
           Range(0.05, 1.5),
           "largest error of the first guess of up");
  list.Add("floor_min_area_m2",
           &floor_min_area_m2,
           Range(0.01, 100),
           "a smaller level surface is never taken as the floor");
  list.Add("floor_min_camera_height_m",
           &floor_min_camera_height_m,
           Range(0, 5),
           "smallest height of cameras above the floor");
}

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
  std::optional<Eigen::Vector3d> up_in_given;
  if (!input.accelerometer.empty()) {
    up_in_given = UpFromAccelerometer(input.accelerometer, RobotPoses(keyframes, input.cameras));
  }
  const auto patches = SampleKeyframes(options, input, keyframes, num_threads);
  return FindMapFrame(options, patches, given_from_cameras, up_in_given);
}

}  // namespace nightmap
