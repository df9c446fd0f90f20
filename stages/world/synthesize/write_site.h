// SPDX-License-Identifier: Apache-2.0
// Files of a synthetic site: pictures, lists, truth.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/base/writing_folder.h"
#include "pipeline/world/recording_files.h"
#include "stages/world/synthesize/synthesize.h"

namespace nightmap {

// The lists of pictures, camera and true poses, if the options want pictures; then the truth about
// the building.
std::vector<RecordingFile> ListsAndTruth(const SynthesizeOptions& options,
                                         const SynthesizePlan& plan);

// Empties the folders of pictures next to `summary`, and removes them when the options want no
// pictures. Removes `summary`, so that a killed run leaves no recording that looks whole, and what
// earlier options made and these do not. Throws DataError when the recording there was not made by
// synthesize.
void ClearRecording(const std::filesystem::path& summary, const SynthesizeOptions& options);

// Writes rgb/NNNNNN.jpg, depth/NNNNNN.png (5000 units per metre) and labels/NNNNNN.png under
// `folder`, which exists. Each file appears complete or not at all, because it is written in
// `writing` and renamed. Throws DataError naming the file.
void WriteFrame(const std::filesystem::path& folder,
                const WritingFolder& writing,
                std::size_t idx,
                const RenderedFrame& frame);

// Renders all pictures into `folder`, as RunSynthesize, after ClearRecording made their folders.
void RenderInto(const std::filesystem::path& folder,
                const SynthesizeOptions& options,
                const SynthesizePlan& plan,
                Progress& progress,
                int num_threads);

// Renders the upward pictures into up/rgb/ of `folder`, as RunUpward, after ClearRecording.
void RenderUpwardInto(const std::filesystem::path& folder,
                      const SynthesizeOptions& options,
                      const SynthesizePlan& plan,
                      Progress& progress,
                      int num_threads);

// Intrinsics and depth scale as JSON.
std::string CameraJson(const SynthesizeOptions& options);

// `floor_plan` for the lowest floor, `floor_plan_N` for those above.
std::string FloorPlanName(std::size_t floor);

// Boxes and floor and ceiling rectangles as JSON, from which distances to the true surfaces are
// measured. Also each floor's height, plan and doorways (two opposite corners of the gap in the
// wall; the passage runs along the shorter side), and the things (true_things.h), each as one box
// with the name of its class; `piece` says which boxes and things are one piece, -1: of none.
// `blank_corridor_m` is the stretch of the corridor without texture (two opposite corners), where
// there is one.
std::string TruthJson(const SyntheticWorld& world);

// All surfaces as a binary PLY mesh of triangles, with the label of each.
std::string TruthMesh(const SyntheticWorld& world);

}  // namespace nightmap
