// SPDX-License-Identifier: Apache-2.0
// Gives query cameras the calibration of the map.
#pragma once

#include <vector>

#include "pipeline/io/frames_io.h"

namespace nightmap {

// A calibrated query camera equal to one of the map's configured cameras takes that camera's
// calibration (from adjust); the others stay. `configured` and `calibrated` correspond by index;
// throws DataError when their sizes differ.
std::vector<RgbdCamera> WithCalibration(std::vector<RgbdCamera> query_cameras,
                                        const std::vector<RgbdCamera>& configured,
                                        const std::vector<RgbdCamera>& calibrated);

}  // namespace nightmap
