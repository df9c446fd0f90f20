// SPDX-License-Identifier: Apache-2.0
// Checks the files of every frame without decoding their pixels.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/base/progress.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/recording/hash_cache.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {

// Fills the hash of each channel (16 hex digits; for a video frame that of the whole video;
// "unreadable" for a color that cannot be read). Fills `problem`, `depth_problem` or
// `others_problems` when a file is missing, truncated, not an image, or of another size or kind
// than its camera's. Removes depth or further channels with a problem from the frame. Deterministic
// at any number of threads and for any content of the cache `files`.
void InspectFrames(const std::vector<RgbdCamera>& cameras,
                   const std::filesystem::path& data_root,
                   HashCache& files,
                   Progress& progress,
                   int num_threads,
                   std::vector<RawSequence>* sequences);

}  // namespace nightmap
