// SPDX-License-Identifier: Apache-2.0
// Frames of a recording that a mosaic is made of.
#pragma once

#include <vector>

#include "pipeline/io/frames_io.h"
#include "pipeline/io/trajectory_io.h"
#include "stages/ceiling/ceiling_mosaic/ceiling_mosaic.h"

namespace nightmap {

// Frames with a pose that are 0.3 m or 0.3 rad from the one before. `poses`: map_from_robot,
// ascending in time.
std::vector<CeilingView> ChooseViews(const std::vector<FrameRecord>& frames,
                                     const std::vector<StampedPose>& poses,
                                     const Rigid3& robot_from_camera);

}  // namespace nightmap
