// SPDX-License-Identifier: Apache-2.0
// The pose_graph stage's text outputs and its accelerometer input.
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

// Columns time_ns, ax_m_per_s2, ay_m_per_s2, az_m_per_s2; the color camera's axes; at least one
// sample, ascending in time. Throws DataError naming file and line.
std::vector<AccelerometerSample> ReadAccelerometer(const std::filesystem::path& path);

}  // namespace nightmap
