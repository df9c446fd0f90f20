// SPDX-License-Identifier: Apache-2.0
// Looks at the files of every frame without decoding their pixels.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/base/progress.h"
#include "pipeline/io/frames_io.h"
#include "stages/frames/frames.h"

namespace nightmap {

// Fills content_hash (16 hex digits of the color file, then of the depth file; of the whole video
// for a video frame; as far as they can be read), and `problem` or `depth_problem` when a file is
// missing, truncated, not an image, or of another size or kind than its camera says. Deterministic
// at any number of threads.
void InspectFrames(const std::vector<RgbdCamera>& cameras,
                   const std::filesystem::path& data_root,
                   Progress& progress,
                   int num_threads,
                   std::vector<RawSequence>* sequences);

}  // namespace nightmap
