// SPDX-License-Identifier: Apache-2.0
// Files of a recording that synthesize_ceiling makes up.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/world/recording_files.h"
#include "stages/ceiling/synthesize_ceiling/synthesize_ceiling.h"

namespace nightmap {

// rgb.txt, odometry.csv, robot_groundtruth.txt, camera_groundtruth.txt and truth/ceiling.json.
std::vector<RecordingFile> CeilingListsAndTruth(const CeilingRecording& recording);

// Samples of the wheels with the header `time_s,x_m,y_m,heading_rad`.
std::string CeilingOdometryCsv(const WheelOdometry& odometry);

// Format nightmap_true_ceiling, version 1: `rectangles` with x0, y0, x1, y1, height_m and finish,
// which tile the free space; `fittings` with kind and bounds; `blank`, the stretch without texture,
// null when there is none. Building frame, metres.
std::string TrueCeilingJson(const CeilingPlan& plan);

// Empties rgb/ next to `summary` and removes `summary`. Throws DataError when another program made
// the recording there.
void ClearCeilingRecording(const std::filesystem::path& summary);

// Renders all pictures into rgb/ of `folder`, after ClearCeilingRecording. Each appears whole or
// not at all. Throws DataError naming the file.
void RenderCeilingInto(const std::filesystem::path& folder,
                       const SynthesizeCeilingOptions& options,
                       const CeilingRecording& recording,
                       Progress& progress,
                       int num_threads);

}  // namespace nightmap
