// SPDX-License-Identifier: Apache-2.0
// The files of the frames stage.
#pragma once

#include <vector>

#include "pipeline/base/stage_main.h"
#include "pipeline/io/frames_io.h"
#include "stages/frames/frames.h"
#include "stages/frames/read_sequence.h"

namespace nightmap {

// Writes shards, queries, the cameras of each, truth and accelerations beside the output
// `shards`, each kept as it is when its bytes did not change, then shards.txt, and fills the
// report. Files of an earlier run that this one does not have (shards beyond the last, truth of a
// site without) are removed. The camera_idx of `lists` count in `cameras`, those of the files in
// the file's own cameras.
void WriteFrames(const FramesOptions& options,
                 const std::vector<RgbdCamera>& cameras,
                 FrameLists lists,
                 const std::vector<Acceleration>& accelerations,
                 StageContext& context);

}  // namespace nightmap
