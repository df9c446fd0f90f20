// SPDX-License-Identifier: Apache-2.0
// The pose_graph stage's text outputs and its input of accelerations.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stages/pose_graph/pose_graph.h"

namespace nightmap {

// TUM text of all frames, or of the keyframes only; map_from_camera.
std::string TrajectoryText(const PoseGraphInput& input,
                           const PoseGraphResult& result,
                           bool only_keyframes);

// The cameras with the focal lengths that were found.
std::vector<RgbdCamera> CalibratedCameras(const PoseGraphInput& input,
                                          const PoseGraphResult& result);

// frame_a,frame_b,status,reason,score,num_putative,num_inliers,drift,error (Mahalanobis distances).
std::string LoopsToCsv(const std::vector<LoopRecord>& loops);

nlohmann::json Summarize(const PoseGraphOptions& options,
                         const PoseGraphInput& input,
                         const PoseGraphResult& result);

// The samples of the first sensor that measures acceleration, turned into the axes of the robot;
// none when there is no such sensor. Throws DataError naming file and field.
std::vector<AccelerometerSample> ReadAcceleration(const std::filesystem::path& path);

}  // namespace nightmap
