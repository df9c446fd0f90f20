// SPDX-License-Identifier: Apache-2.0
// import_trajectory: takes the frame poses of another system in place of pose_graph's, and chooses
// the keyframes of the map.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/frames_io.h"
#include "stages/camera/import_trajectory/motion_check.h"
#include "stages/camera/import_trajectory/pose_jumps.h"

namespace nightmap {

struct ImportTrajectoryOptions {
  OPTION(double, keyframe_distance_m, 0.15, {0, 10},
         "distance from the last keyframe at which a frame becomes one");
  OPTION(double, keyframe_turn_rad, 0.2, {0, 3.2},
         "rotation from the last keyframe at which a frame becomes one");
  OPTION(double, min_posed_ratio, 0.5, {0, 1}, "share of the frames that must have a pose");
  OPTION(bool, check_motion, true,
         "refuses a trajectory that contradicts the motion that pictures and depth show");
  REGISTER_OPTIONS();
};

struct ImportedTrajectory {
  std::vector<StampedPose> poses;      // given_from_camera of the frames that have one, by time
  std::vector<StampedPose> keyframes;  // the first pose, and each that moved or turned enough
                                       // since the keyframe before
};

// `given` holds given_from_camera poses (color camera, x right, y down, z forward) of another
// system at its own times, ascending. A frame's pose is interpolated at its time between poses at
// most 0.1 s apart (TruthAt); other frames get none. Pure and deterministic.
ImportedTrajectory RunImportTrajectory(const ImportTrajectoryOptions& options,
                                       const std::vector<FrameRecord>& frames,
                                       const std::vector<StampedPose>& given);

// Throws ThresholdError naming `file` and the remedy when fewer than min_posed_ratio of the frames
// got a pose, or none.
void JudgeNumPosed(const ImportTrajectoryOptions& options,
                   const std::vector<FrameRecord>& frames,
                   const std::vector<StampedPose>& given,
                   std::size_t num_posed,
                   const std::string& file);

// Throw DataError naming `file` and the remedy when the trajectory cannot be right; log a warning
// of what is doubtful.
void JudgeMotions(const MotionVerdict& verdict, const std::string& file);
void JudgeJumps(const PoseJumps& jumps, const std::string& file);

}  // namespace nightmap
