// SPDX-License-Identifier: Apache-2.0
// Files of a synthetic site: pictures, lists, truth.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/base/writing_folder.h"
#include "stages/synthesize/synthesize.h"

namespace nightmap {

// Empties the folders of pictures beside `summary` and removes it, so that a run that is killed
// leaves no recording that looks whole. Throws DataError when the recording there is not one of
// synthesize.
void ClearRecording(const std::filesystem::path& summary);

// Writes rgb/NNNNNN.jpg, depth/NNNNNN.png (5000 units a metre) and labels/NNNNNN.png under
// `folder`, which exists; each appears complete or not at all, since it is written in `writing` and
// renamed. Throws DataError naming the file.
void WriteFrame(const std::filesystem::path& folder,
                const WritingFolder& writing,
                std::size_t idx,
                const RenderedFrame& frame);

// TUM list of time and file: `rgb` with extension jpg, `depth` with png.
std::string FileList(const std::vector<StampedPose>& poses,
                     const std::string& folder,
                     const std::string& extension);

// Intrinsics and depth scale as JSON.
std::string CameraJson(const SynthesizeOptions& options);

// `floor_plan`, and of floors above the lowest `floor_plan_N`.
std::string FloorPlanName(std::size_t floor);

// Boxes and floor and ceiling rectangles as JSON, for distances of points to the true surfaces; the
// floors with their heights, the plan and the doorways of each (two opposite corners of the gap in
// the wall; the way through is along the shorter side).
std::string TruthJson(const SyntheticWorld& world);

// All surfaces as a binary PLY mesh of triangles, with the label of each.
std::string TruthMesh(const SyntheticWorld& world);

}  // namespace nightmap
