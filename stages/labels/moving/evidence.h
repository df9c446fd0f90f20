// SPDX-License-Identifier: Apache-2.0
// Evidence of the frames before and after for each surface that a frame shows: does it stay?
#pragma once

#include "pipeline/geometry/rigid3.h"
#include "stages/labels/moving/small_frame.h"

namespace nightmap {

struct EvidenceOptions {
  double num_sigmas = 2;             // of both depths, for two surfaces to differ
  double min_difference_m = 0.03;    // besides: errors of the motion
  int max_gray_difference = 40;      // of a surface that is the same
  double max_flow_px = 2;            // of a corner that stays, off the place where it should be
  double max_patch_difference = 12;  // gray levels, between a corner and where it is followed to
};

// Evidence for and against each pixel of reduced depth, summed over the other frames.
struct Evidence {
  explicit Evidence(const DepthImage& depth) : gone(ZerosLike(depth)), stays(gone) {}

  Evidence& operator+=(const Evidence& more);

  Image<float> gone;   // for having left the place where the frame shows it
  Image<float> stays;  // for being there still
};

// Two depths of about depth_m that differ by more are of two surfaces.
double Margin_m(const EvidenceOptions& options, const SmallCamera& camera, double depth_m);

// Compares the frame's surfaces with the depth of another frame, moved there as if they stood
// still. A surface has gone where all around its place is farther off: one sees through it. It
// stays where something around its place has its depth and gray. A place hidden in the other frame,
// outside of it or beside a hole says nothing.
void AddDepthEvidence(const EvidenceOptions& options,
                      const SmallCamera& camera,
                      const SmallFrame& frame,
                      const SmallFrame& other,
                      const Rigid3& other_from_frame,
                      Evidence* evidence);

}  // namespace nightmap
