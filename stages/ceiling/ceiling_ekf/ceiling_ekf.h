// SPDX-License-Identifier: Apache-2.0
// ceiling_ekf: the way of a robot with an upward camera and wheel odometry, and the landmarks of
// the ceiling, by EKF-SLAM.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/ceiling/ceiling_map_io.h"
#include "pipeline/ceiling/corner_tracks_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/recording/choose_signal.h"
#include "pipeline/recording/signals_io.h"
#include "stages/ceiling/ceiling_ekf/ceiling_filter.h"
#include "stages/ceiling/ceiling_ekf/landmark_keeper.h"
#include "stages/ceiling/ceiling_ekf/submap_match.h"

namespace nightmap {

struct CeilingEkfOptions {
  OPTIONS_OF(OdometryChoice, odometry);
  OPTIONS_OF(CeilingNoise, noise);
  OPTIONS_OF(KeeperOptions, keeper);
  OPTIONS_OF(SubmapMatchOptions, loops);
  OPTION(double, max_missing_ratio, 0.2, {0, 1},
         "fails when a larger share of the frames has no odometry");
  REGISTER_OPTIONS();
};

struct CeilingEkfInput {
  CornerTracks tracks;           // of the whole site
  RgbdCamera camera;             // the one that made them; its depth is not used
  std::vector<Signal> odometry;  // of all sensors that measure it
};

struct CeilingEkfResult {
  CeilingMap map;
  KeeperCounts counts;
  std::string odometry_sensor;
  int num_without_odometry = 0;  // frames
  int num_slipped = 0;
  int num_blind = 0;  // frames that used no landmark
  int num_searches_without_loop = 0;
  double heading_error_rad_per_m = 0;
  Eigen::Vector2d mounting_tilt_rad = Eigen::Vector2d::Zero();
};

// CN103680291A: prediction by the wheels, observation of the tracked corners with gates, update,
// and a map that is added to, modified and deleted from (ceiling_filter.h, landmark_keeper.h).
// At 3 m from the last one the robot's place becomes an anchor, and the landmarks around it are
// compared with those of places that it left 8 m of way ago or more (submap_match.h): what is met
// again closes a loop, and moves the anchors and all that hangs on them. Where the odometry has a
// gap, the robot is somewhere within its unknown speed; where the camera sees no landmark, the
// wheels go on alone. Throws UsageError when `odometry_sensor` names none, or none among several,
// InputError when there is no odometry, or none for more than `max_missing_ratio` of the frames.
// Deterministic; one thread.
CeilingEkfResult RunCeilingEkf(const CeilingEkfOptions& options,
                               const CeilingEkfInput& input,
                               Progress& progress);

}  // namespace nightmap
