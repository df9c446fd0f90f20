// SPDX-License-Identifier: Apache-2.0
// The files of the frames stage.
#pragma once

#include <vector>

#include "pipeline/io/frames_io.h"
#include "pipeline/io/signals_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/frames/frames.h"

namespace nightmap {

// Writes beside the output `shards` the shards, held-out frames, cameras, truth, and the signals of
// each kind, each kept as it is when its bytes did not change, then shards.txt, and fills the
// report. Files of an earlier run that this one does not have (shards beyond the last, truth of a
// site without) are removed. The camera_idx of `lists` count in `cameras`; so do those of the
// held-out frames, whose cameras the site config says, while those of the shards count in
// cameras.json.
void WriteFrames(const FramesOptions& options,
                 const std::vector<RgbdCamera>& cameras,
                 FrameLists lists,
                 const std::vector<Signal>& signals,
                 StageContext& context);

}  // namespace nightmap
