// SPDX-License-Identifier: Apache-2.0
// Where up is and where the floor lies, from what the depth images see.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/frames_io.h"
#include "stages/pose_graph/surface_patches.h"

namespace nightmap {

struct MapFrameOptions {
  int floor_num_keyframes = 120;
  double floor_max_depth_m = 4.0;
  double floor_max_tilt_rad = 0.7;
  double floor_min_area_m2 = 0.2;
  double floor_min_camera_height_m = 0.3;

  void Register(OptionList& list);
};

// One sample of an accelerometer, along the axes of the robot.
struct AccelerometerSample {
  std::int64_t time_ns = 0;
  Eigen::Vector3d acceleration_m_per_s2 = Eigen::Vector3d::Zero();
};

// Up in the graph frame, of unit length: at rest an accelerometer measures up, and what the
// camera's own motion adds cancels in the mean. Each keyframe (its time and graph_from_robot)
// turns the mean of the samples within 0.1 s of it. `samples` ascend in time. Throws DataError when
// no keyframe has a sample or the mean is far from gravity.
Eigen::Vector3d UpFromAccelerometer(const std::vector<AccelerometerSample>& samples,
                                    const std::vector<StampedPose>& keyframes);

// Below a floor nothing is seen but noise: what is this deep, and how much there may be of it.
inline constexpr double kBelowFloor_m = 0.3;
inline constexpr double kMaxBelowFloorShare = 0.05;

struct MapFrame {
  Rigid3 map_from_graph;
  std::string gravity_source;  // "accelerometer", "horizontal surfaces" or "camera attitude"
  // Names the surface at z = 0: "floor plane", or where no floor was seen "lowest horizontal
  // plane", "lowest points" or "lowest camera".
  std::string floor_source;
  double floor_area_m2 = 0;
  int floor_num_keyframes = 0;   // that saw it, of those that were searched
  double camera_height_m = 0;    // median above the floor
  double below_floor_share = 0;  // of the measured points that lie more than kBelowFloor_m below it
};

// Up: `up_in_graph` of an accelerometer if given, else the mean of the cameras' up axes; refined to
// the common normal of the surfaces that face it. Floor: as of ChooseFloor, the lowest level
// surface below the cameras. The map's origin is below the first camera, its x axis along the first
// camera's view. Deterministic.
MapFrame FindMapFrame(const MapFrameOptions& options,
                      const std::vector<SurfacePatch>& patches,
                      const std::vector<Rigid3>& graph_from_cameras,
                      const std::optional<Eigen::Vector3d>& up_in_graph);

}  // namespace nightmap
