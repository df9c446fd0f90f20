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
  std::string method = "surfaces";
  CameraMotionOptions camera_motion;
  EvidenceOptions evidence;
  SpreadOptions spread;
  EpipolarOptions published;
  std::vector<double> offsets_s = {0.2, 0.4, 0.8};
  int margin_px = 6;
  int seed = 0;
  double max_failed_ratio = 0.2;

  void Register(OptionList& list);
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
