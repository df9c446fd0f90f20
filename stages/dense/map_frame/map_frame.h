// SPDX-License-Identifier: Apache-2.0
// map_frame: moves a finished trajectory from its own frame ("given") to the map frame: z up, floor
// at z = 0. It is a stage of its own so that another choice of the floor repeats no adjustment and
// so that a trajectory made by another system gets a floor too.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/dense/tiles_io.h"
#include "pipeline/geometry/rigid3.h"
#include "stages/dense/map_frame/accelerometer.h"

namespace nightmap {

struct MapFrameOptions {
  OPTION(std::string, source, "floor", {"floor", "given"},
         "floor: the map frame has z up and the detected floor at z = 0; given: the map frame is "
         "that of the input trajectory, which has z up already");
  OPTION(int, floor_num_keyframes, 120, {1, 10000},
         "keyframes whose depth is searched for the floor");
  OPTION(double, floor_max_tilt_rad, 0.7, {0.05, 1.5}, "largest error of the first guess of up");
  double floor_min_area_m2 = 0.2;  // a smaller level surface is never taken as the floor
  OPTION(double, floor_min_camera_height_m, 0.3, {0, 5},
         "smallest height of cameras above the floor");
  REGISTER_OPTIONS();
};

struct MapFrameInput {
  std::vector<StampedPose> keyframes;  // given_from_camera, ascending in time; at least one
  std::vector<FrameRecord> frames;     // include the frame of each keyframe
  std::vector<RgbdCamera> cameras;
  std::vector<AccelerometerSample> accelerometer;  // ascending in time; empty: there is none
  std::function<DepthImage(const FrameRecord&)> load_depth;  // throws DataError when unreadable
};

// Only noise is seen below a floor: the depth from which points count as below it, and the largest
// share of such points that is plausible.
inline constexpr double kBelowFloor_m = 0.3;
inline constexpr double kMaxBelowFloorShare = 0.05;

struct MapFrame {
  Rigid3 map_from_given;
  // "accelerometer"; "horizontal surfaces" or "camera attitude" where the camera was held as it is
  // mounted, "surfaces and motion" where another direction fits better; "given trajectory".
  std::string gravity_source;
  // Where up was found by pictures: see UpChoice.
  std::optional<double> up_odds;
  std::string up_direction, next_up_direction;
  // Names the surface at z = 0: "floor plane"; where no floor was seen "lowest horizontal plane",
  // "lowest points" or "lowest camera"; "given trajectory" where nothing was searched.
  std::string floor_source;
  double floor_area_m2 = 0;
  int floor_num_keyframes = 0;   // number of searched keyframes that saw it
  double camera_height_m = 0;    // median height above the floor
  double below_floor_share = 0;  // share of measured points more than kBelowFloor_m below the floor

  bool IsGiven() const { return floor_source == kGiven; }
  static constexpr const char* kGiven = "given trajectory";
};

// With source "given" the map frame equals the given frame, and no depth is read. Throws DataError
// when a keyframe has no frame, and as UpFromAccelerometer does. Deterministic at any number of
// threads.
MapFrame RunMapFrame(const MapFrameOptions& options, const MapFrameInput& input, int num_threads);

}  // namespace nightmap
