// SPDX-License-Identifier: Apache-2.0
// labels: the class of every pixel of each frame of a list.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/labels/labelled_frames.h"

namespace nightmap {

struct LabelsOptions {
  OPTION(double, max_failed_ratio, 0.2, {0, 1},
         "fails when a larger share of the frames to label failed");
  REGISTER_OPTIONS();
};

struct LabelsResult {
  std::size_t num_to_label = 0;
  std::vector<std::string> skipped;  // reasons, in frame order
};

// Labels every frame that can be labelled. `load` may throw as LoadRgbd; a frame that throws what
// FrameFailure catches is left out.
LabelsResult RunLabels(const std::vector<FrameRecord>& frames,
                       const std::function<RgbdImages(const FrameRecord&)>& load,
                       LabelledFrames* labelled,
                       Progress& progress,
                       int num_threads);

}  // namespace nightmap
