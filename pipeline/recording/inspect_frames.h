// SPDX-License-Identifier: Apache-2.0
// Looks at the files of every frame without decoding their pixels.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/base/progress.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/recording/file_facts.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {

// Fills the hash of each channel (16 hex digits; of the whole video for a video frame; "unreadable"
// for a color that cannot be read), and `problem`, `depth_problem` or `others_problems` when a file
// is missing, truncated, not an image, or of another size or kind than its camera says. A depth or
// further channel with a problem is taken from the frame. Deterministic at any number of threads,
// and whatever `files` knows already.
void InspectFrames(const std::vector<RgbdCamera>& cameras,
                   const std::filesystem::path& data_root,
                   FileFactsCache& files,
                   Progress& progress,
                   int num_threads,
                   std::vector<RawSequence>* sequences);

}  // namespace nightmap
