// SPDX-License-Identifier: Apache-2.0
// Regions that may move by their labels, and do, each as a whole: people who stand or sit stay
// (the decision per object of CN108596974A, by the evidence of this stage).
#pragma once

#include <optional>
#include <vector>

#include "pipeline/labels/labelled_regions.h"
#include "stages/labels/moving/evidence.h"

namespace nightmap {

// Word of one other frame on a region: -1 (it stays) .. 1 (it has gone); none: it says nothing.
using RegionScore = std::optional<double>;

// The scores by the frames at each of the offsets before and after, the nearest first.
struct RegionScores {
  std::vector<RegionScore> before;
  std::vector<RegionScore> after;
};

// A frame's regions and what is known of each, by its number less 1.
struct FrameRegions {
  LabelledRegions regions;
  std::vector<RegionScores> scores;
};

// Adds the scores by the evidence of one other frame, which is the first at so many of the offsets,
// to `before` or `after`. Signs that it stays count stays_weight against what has gone, and by
// depth a third of it: what goes slowly has the same depth and gray still, and its corners are
// followed elsewhere.
void AddScores(double stays_weight,
               const Evidence& by_depth,
               const Evidence& by_flow,
               bool forward,
               int num_offsets,
               FrameRegions* frame);

// For each region of a frame the region of the next that shows most of its pixels, if these are
// half of the larger of both, so that a scrap of a mask is not taken for the whole; else 0. Each
// pixel is sought where it is seen if it stays.
std::vector<int> SameRegions(const SmallCamera& camera,
                             const SmallFrame& frame,
                             const FrameRegions& regions,
                             const FrameRegions& next,
                             const Rigid3& next_from_frame);

// Whether each region of each frame moves. One that clearly stays where it is until the nearest
// frame after, or since that before, does not: its features fit one of them. Another one moves when
// a frame before and another as long after both say that it has gone, or the only one of them that
// says anything; or when no frame says anything, as labels say. Regions that move in a frame move
// in the next and in the one before as well, unless it clearly stays there. `same[k]`:
// SameRegions of frame k and k + 1. Deterministic.
std::vector<std::vector<bool>> DecideRegions(const std::vector<const FrameRegions*>& frames,
                                             const std::vector<std::vector<int>>& same);

}  // namespace nightmap
