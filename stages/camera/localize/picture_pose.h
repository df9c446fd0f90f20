// SPDX-License-Identifier: Apache-2.0
// Pose of a picture from matches of its pixels with landmarks, and the focal length of a lens that
// is not calibrated.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/geometry/absolute_pose.h"
#include "stages/camera/localize/localize.h"

namespace nightmap {

// Knowledge of the lens that took a picture.
struct PictureLens {
  Camera camera;
  double focal_sigma_ratio = 0;  // of the camera's focal length, as in RgbdCamera; 0: calibrated

  bool IsCalibrated() const { return focal_sigma_ratio == 0; }
};

struct PicturePose {
  AbsolutePose pose;  // its covariance includes that of the lens
  Camera camera;      // with the lens that was found
};

// The lens with focal lengths to start from. They come nearest first, in steps so small that RANSAC
// finds inliers with the nearest, and reach from a picture cropped to less than half to one that
// was taken with twice the zoom. A calibrated lens: its camera alone.
std::vector<Camera> LensesToTry(const PictureLens& lens);

// A calibrated lens: RANSAC and refinement, as EstimateAbsolutePose. Another one: likewise with
// each camera of `starts` until one explains most matches, each time followed by least squares over
// pose and lens; the result is the one with the most inliers. Returns nothing when fewer than
// min_inliers agree. Deterministic in the seed.
std::optional<PicturePose> EstimatePicturePose(const LocalizeOptions& options,
                                               const PictureLens& lens,
                                               const std::vector<Camera>& starts,
                                               const std::vector<PointMatch>& matches,
                                               int min_inliers,
                                               std::uint64_t seed);

// Refines the pose together with camera motion during readout. Returns nothing when that explains
// fewer matches.
std::optional<PicturePose> AllowMotion(const LocalizeOptions& options,
                                       const PictureLens& lens,
                                       const std::vector<PointMatch>& matches,
                                       const PicturePose& still);

}  // namespace nightmap
