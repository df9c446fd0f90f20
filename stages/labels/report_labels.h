// SPDX-License-Identifier: Apache-2.0
// Figures of a labels run for its report.
#pragma once

#include <nlohmann/json.hpp>

#include "stages/labels/labels.h"

namespace nightmap {

// Counts of frames, mean share of the pixels of each class that occurs, and per labelled frame its
// frame_idx and the share of its pixels that may move.
void ReportLabels(const LabelsResult& result,
                  const LabelClasses& classes,
                  std::size_t num_frames,
                  nlohmann::json* report);

}  // namespace nightmap
