// SPDX-License-Identifier: Apache-2.0
// moving: which pixels of each frame of a shard show what moves, by depth and motion, and by labels
// where there are some.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/masks_io.h"
#include "stages/labels/moving/camera_motion.h"
#include "stages/labels/moving/epipolar_check.h"
#include "stages/labels/moving/evidence.h"
#include "stages/labels/moving/spread.h"

namespace nightmap {

struct MovingOptions {
  OPTION(std::string, method, "surfaces", {"surfaces", "published"},
         "surfaces: depth and flow over up to a second; published: the check of epipolar lines, "
         "with the options margin_px and seed alone");
  CameraMotionOptions camera_motion;
  OPTION_AT("max_error_px", camera_motion.max_error_px, {0.2, 10},
            "inlier threshold on reprojection, in the reduced picture");
  OPTION_AT("min_inliers", camera_motion.min_inliers, {4, 1000},
            "smallest number of corners that agree with a motion");
  OPTION_AT("min_share", camera_motion.min_share, {0, 1},
            "a motion that less of the surface agrees with is not the camera's");
  OPTION(std::vector<double>, offsets_s, std::vector<double>({0.2, 0.4, 0.8}), {0.01, 10},
         "a frame is compared with the frames so long before and after it");
  EvidenceOptions evidence;
  SpreadOptions spread;
  OPTION_AT("max_patch_difference", evidence.max_patch_difference, {0, 255},
            "largest difference between a corner and where it is followed to, in gray levels");
  OPTION_AT("prior", spread.prior, {0, 10}, "evidence that each pixel has for staying without any");
  EpipolarOptions published;
  OPTION(int, margin_px, 6, {0, 100}, "widens the masks");
  OPTION(int, seed, 0, {0, 1e6}, "seed of RANSAC");
  OPTION(double, max_failed_ratio, 0.2, {0, 1}, "fails when a larger share of the frames failed");
  REGISTER_OPTIONS();
};

struct MovingInput {
  std::vector<FrameRecord> frames;
  std::vector<RgbdCamera> cameras;
  RgbdLoader load;
};

struct MovingResult {
  std::vector<std::optional<PackedMask>> masks;  // per frame; none of a frame that failed
  std::vector<double> moving_shares;             // of the pixels of each frame; 0 if it failed
  int num_pairs = 0;                             // of frames in succession
  int num_pairs_without_motion = 0;
  std::vector<std::string> skipped;  // reasons, in frame order
};

// 1. Reduces the frames, and finds the camera's motion between those in succession.
// 2. Compares the surfaces of each frame with the depth of those offsets_s before and after it, and
// follows its corners there. Stops where the motion is not known.
// 3. Decides of each region of what labels say may move (RgbdImages::moving of the loaded frames)
// whether it does, as a whole.
// 4. Spreads what is found over connected surfaces; what has more against staying than for it
// moves.
// The method "published" takes the frame before alone instead (epipolar_check.h): a region in which
// points leave their epipolar lines moves, as a whole, and so do single points elsewhere.
// Frames of another camera or sequence are not compared. Deterministic at any number of threads.
MovingResult RunMoving(const MovingOptions& options,
                       const MovingInput& input,
                       Progress& progress,
                       int num_threads);

}  // namespace nightmap
