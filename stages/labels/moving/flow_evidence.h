// SPDX-License-Identifier: Apache-2.0
// Evidence of optical flow for each surface that a frame shows: the inside of a large thing that
// moves hides itself, and only its texture tells.
#pragma once

#include "stages/labels/moving/evidence.h"

namespace nightmap {

// Follows the frame's corners to another frame, from where they are seen there if they stay. A
// corner found elsewhere has gone, with the surface around it. One at an edge of depth, hidden in
// the other frame, or of another look there says nothing.
void AddFlowEvidence(const EvidenceOptions& options,
                     int window_px,
                     const SmallCamera& camera,
                     const SmallFrame& frame,
                     const SmallFrame& other,
                     const Rigid3& other_from_frame,
                     Evidence* evidence);

}  // namespace nightmap
