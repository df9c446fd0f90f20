// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/adjust.h"

namespace nightmap {

void AdjustOptions::Register(OptionList& list) {
  list.Add(
      "max_seen_ratio",
      &max_seen_ratio,
      Range(0.5, 1),
      "a keyframe is dropped when three others see a larger share of its points; 1: drops none");
  list.Add(
      "bundle_iterations", &bundle_iterations, Range(1, 500), "iterations per bundle adjustment");
  list.Add("bundle_max_error_px",
           &bundle_max_error_px,
           Range(0.5, 50),
           "observations with a larger error are dropped");
  list.Add("final_adjustment",
           &final_adjustment,
           "also adjusts all described frames, with points found anew by projection");
  list.Add("calibrate",
           &calibrate,
           "estimates each camera's focal length and rolling shutter in the final adjustment");
  list.Add("retrack_max_error_px",
           &retrack.max_error_px,
           Range(0.5, 50),
           "largest distance from a projected point to a feature that observes it");
  list.Add("retrack_max_descriptor_distance",
           &retrack.max_descriptor_distance,
           Range(0.05, 1),
           "largest descriptor distance of a feature that observes a point; 1: as unrelated "
           "descriptors");
  list.Add("estimate_depth_scales",
           &estimate_depth_scales,
           "estimates the depth scale of each camera relative to the first camera");
  list.Add("max_tracks_per_keyframe",
           &max_tracks_per_keyframe,
           Range(20, 10000),
           "longest tracks per frame that enter bundle adjustment");
}

}  // namespace nightmap
