// SPDX-License-Identifier: Apache-2.0
// Pose of a picture from matches of its pixels with landmarks, and the focal length of a lens that
// is not calibrated.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/geometry/absolute_pose.h"
#include "stages/localize/localize.h"

namespace nightmap {

// What is known of the lens that took a picture.
struct PictureLens {
  Camera camera;
  double focal_sigma_ratio = 0;  // of the camera's focal length, as in RgbdCamera; 0: calibrated

  bool IsCalibrated() const { return focal_sigma_ratio == 0; }
};

struct PicturePose {
  AbsolutePose pose;       // its covariance includes that of the focal length
  double focal_scale = 1;  // focal length over that of the lens
  // Standard deviation of the logarithm of that focal length; 0: calibrated.
  double focal_sigma_ratio = 0;
};

// Focal lengths to start from, relative to an uncertain one. They come nearest first, in steps so
// small that RANSAC finds inliers with the nearest, and reach from a picture cropped to less than
// half to one that was taken with twice the zoom.
std::vector<double> FocalLadder();

// A calibrated lens: RANSAC and refinement, as EstimateAbsolutePose. Another one: likewise with
// each focal length of `focal_scales` until one explains most matches, each time followed by least
// squares over pose and focal length; the result is the one with the most inliers. Returns nothing
// when fewer than min_inliers agree. Deterministic in the seed.
std::optional<PicturePose> EstimatePicturePose(const LocalizeOptions& options,
                                               const PictureLens& lens,
                                               const std::vector<double>& focal_scales,
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
