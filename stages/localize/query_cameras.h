// SPDX-License-Identifier: Apache-2.0
// Cameras of the queries as the map knows them.
#pragma once

#include <vector>

#include "pipeline/io/frames_io.h"

namespace nightmap {

// A query camera that is one of the map's as they were configured takes what mapping found out
// about it (pose_graph's calibration); the others stay. `configured` and `calibrated` belong
// together one by one; throws DataError when their numbers differ.
std::vector<RgbdCamera> WithCalibration(std::vector<RgbdCamera> query_cameras,
                                        const std::vector<RgbdCamera>& configured,
                                        const std::vector<RgbdCamera>& calibrated);

}  // namespace nightmap
