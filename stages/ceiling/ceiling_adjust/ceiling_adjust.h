// SPDX-License-Identifier: Apache-2.0
// ceiling_adjust: the smoother after the filter. The way of a robot under a ceiling and its
// landmarks, by all pictures and all motions of the wheels at once.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/ceiling/ceiling_map_io.h"
#include "pipeline/ceiling/ceiling_noise.h"
#include "pipeline/ceiling/corner_tracks_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/choose_signal.h"
#include "pipeline/recording/signals_io.h"
#include "stages/ceiling/ceiling_adjust/ceiling_problem.h"

namespace nightmap {

struct CeilingAdjustOptions {
  OPTIONS_OF(OdometryChoice, odometry);
  OPTION(double, keyframe_distance_m, 0.15, {0.01, 10},
         "distance between keyframes, which are what is adjusted");
  OPTION(double, ceiling_height_m, 0, {0, 100},
         "height above the floor, measured, of the level at which most of the ceiling is: tells "
         "the map's size; 0: unknown, the wheels tell it");
  OPTION(double, ceiling_height_sigma_m, 0.005, {1e-4, 1},
         "how well ceiling_height_m is known, with the height of the camera on the robot");
  OPTIONS_OF(CeilingNoise, noise);
  REGISTER_OPTIONS();
};

struct CeilingAdjustInput {
  CornerTracks tracks;                  // of the whole site
  CeilingMap map;                       // of the filter
  std::vector<StampedPose> trajectory;  // of the filter: map_from_robot at each frame of the map
  RgbdCamera camera;                    // the one that made the tracks; its depth is not used
  std::vector<Signal> odometry;         // of all sensors that measure it
};

struct CeilingAdjustResult {
  // The filter's map with adjusted positions of landmarks and `map_from_robot` of frames. Landmarks
  // that fewer than three keyframes saw are left out. Anchors and covariances stay the filter's,
  // which knew less.
  CeilingMap map;
  int num_keyframes = 0;
  int num_sightings = 0;
  int num_guessed_motions = 0;  // without odometry, or with slipping wheels
  Vector5d mounting = Vector5d::Zero();
  Eigen::Vector2d wheels = Eigen::Vector2d::Zero();
  double level_m = 0;  // height of the level at which most landmarks are
  CeilingSolution solution;
};

// Frames `keyframe_distance_m` or 0.1 rad apart are keyframes; those between move along
// with the two around them. Landmarks are those of the filter, seen by all tracks that it says are
// theirs, so that its loops hold. Estimated are all keyframes and landmarks, how the robot tilts in
// each keyframe, the camera's mounting, and what the wheels get wrong all the time.
// `ceiling_height_m` (0: unknown) is the measured height of the level at which most landmarks are;
// it gives the map its size, which else is the wheels'. Throws UsageError as ChooseOdometry,
// InputError when trajectory and map do not belong together or no landmark is seen by three
// keyframes. Deterministic; one thread.
CeilingAdjustResult RunCeilingAdjust(const CeilingAdjustOptions& options,
                                     const CeilingAdjustInput& input,
                                     Progress& progress);

}  // namespace nightmap
