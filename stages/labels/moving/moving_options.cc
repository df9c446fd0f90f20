// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/moving.h"

namespace nightmap {

void MovingOptions::Register(OptionList& list) {
  list.Add("method",
           &method,
           {"surfaces", "published"},
           "surfaces: depth and flow over up to a second; published: the check of epipolar lines, "
           "with the options published_*, cell_px, window_px, margin_px and seed alone");
  list.Add("cell_px",
           &camera_motion.cell_px,
           Range(4, 64),
           "one corner is followed per cell of the reduced picture, which is about 320 wide");
  list.Add("window_px", &camera_motion.window_px, Range(5, 63), "size of the patch followed");
  list.Add("max_error_px",
           &camera_motion.max_error_px,
           Range(0.2, 10),
           "inlier threshold on reprojection, in the reduced picture");
  list.Add("max_depth_error",
           &camera_motion.max_depth_error,
           Range(0.005, 1),
           "inlier threshold on measured depth, relative");
  list.Add("min_inliers",
           &camera_motion.min_inliers,
           Range(4, 1000),
           "smallest number of corners that agree with a motion");
  list.Add("min_share",
           &camera_motion.min_share,
           Range(0, 1),
           "a motion that less of the surface agrees with is not the camera's");
  list.Add("offsets_s",
           &offsets_s,
           Range(0.01, 10),
           "a frame is compared with the frames so long before and after it");
  list.Add("num_sigmas",
           &evidence.num_sigmas,
           Range(0, 10),
           "two depths differ by more than so many standard deviations of both");
  list.Add("min_difference_m",
           &evidence.min_difference_m,
           Range(0, 1),
           "and by so much more, for errors of the motion");
  list.Add("max_gray_difference",
           &evidence.max_gray_difference,
           Range(1, 255),
           "of a surface that stays, in gray levels");
  list.Add("stays_weight",
           &spread.stays_weight,
           Range(0.01, 10),
           "how much a surface that stays counts, against one that is gone");
  list.Add("max_flow_px",
           &evidence.max_flow_px,
           Range(0.1, 20),
           "a corner followed farther than this from where it should be moves, in the reduced "
           "picture");
  list.Add("max_patch_difference",
           &evidence.max_patch_difference,
           Range(0, 255),
           "largest difference between a corner and where it is followed to, in gray levels");
  list.Add(
      "prior", &spread.prior, Range(0, 10), "evidence that each pixel has for staying without any");
  list.Add("max_depth_step",
           &spread.max_depth_step,
           Range(0.001, 1),
           "relative step of depth between neighbours that is an edge between two things");
  list.Add("published_border_px",
           &published.border_px,
           Range(0, 100),
           "points nearer to the border are dropped, in the reduced picture");
  list.Add("published_max_patch_difference",
           &published.max_patch_difference,
           Range(0, 255),
           "largest mean difference of 3 x 3 pixels around a point and where it is followed to, in "
           "gray levels");
  list.Add("published_ransac_px",
           &published.ransac_px,
           Range(0.01, 10),
           "inlier threshold of the fundamental matrix");
  list.Add("published_ransac_confidence",
           &published.ransac_confidence,
           Range(0.5, 0.999999),
           "how surely the largest agreement is to be found");
  list.Add("published_max_epipolar_px",
           &published.max_epipolar_px,
           Range(0.05, 20),
           "a point farther from its epipolar line moves");
  list.Add("published_min_points",
           &published.min_points,
           Range(15, 10000),
           "pictures with fewer pairs of points say nothing");
  list.Add("published_min_moving_points",
           &published.min_moving_points,
           Range(1, 10000),
           "a labelled region with so many points that move does");
  list.Add("margin_px", &margin_px, Range(0, 100), "widens the masks");
  list.Add("seed", &seed, Range(0, 1e6), "seed of RANSAC");
  list.Add("max_failed_ratio",
           &max_failed_ratio,
           Range(0, 1),
           "fails when a larger share of the frames failed");
}

}  // namespace nightmap
