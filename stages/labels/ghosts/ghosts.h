// SPDX-License-Identifier: Apache-2.0
// ghosts: what stood still before the camera and is gone at another time, for leaving it out of the
// map. Poses and features profit from people who sit; a map that is used for years does not.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/dense/tiles_io.h"
#include "pipeline/io/masks_io.h"

namespace nightmap {

struct GhostsOptions {
  OPTION(double, min_share, 0.5, {0.01, 1},
         "of a thing as far as the other keyframe sees it, that it must see through");
  OPTION(int, min_keyframes, 2, {1, 1000},
         "a thing that so many keyframes see through is gone at another time, and left out of the "
         "map");
  OPTION(double, max_failed_ratio, 0.2, {0, 1},
         "fails when a larger share of the keyframes failed");
  REGISTER_OPTIONS();
};

struct GhostsInput {
  std::vector<RgbdCamera> cameras;
  std::vector<Keyframe> keyframes;
  // Pictures of one keyframe, of its camera's size; called from several threads. They throw
  // what FrameFailure catches when they cannot be read.
  std::function<DepthImage(const Keyframe&)> depth;    // 0 where something moves
  std::function<GrayImage(const Keyframe&)> moving;    // not 0 there; empty: nothing is known
  std::function<GrayImage(const Keyframe&)> may_move;  // by its label; empty: nothing is labelled
};

struct GhostsResult {
  // Per keyframe: what moves in it, and the ghosts; none where nothing is known, or it failed.
  std::vector<std::optional<PackedMask>> masks;
  int num_regions = 0;  // that may move by their label and stand still
  int num_ghosts = 0;   // of them
  std::vector<std::string> skipped;
};

// A region of a keyframe (FindLabelledRegions) that stands still is a ghost when at least
// min_keyframes others see through min_share of it: their depth all around its place is farther by
// 0.1 m and two sigmas of the noise. It may have come or have left: other times are
// before and after. A place hidden, outside the picture or not measured says nothing. Memory: 30 kB
// per keyframe, and 24 bytes per block that may move. The same at any number of threads.
GhostsResult RunGhosts(const GhostsOptions& options,
                       const GhostsInput& input,
                       Progress& progress,
                       int num_threads);

}  // namespace nightmap
