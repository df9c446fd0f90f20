// SPDX-License-Identifier: Apache-2.0
// Shared by the lists of frames and of queries.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/io/frames_io.h"

namespace nightmap {

// The pose at exactly that time, or interpolated between neighbours at most 0.1 s apart (rotation
// by slerp). A longer gap is a dropout: interpolating over it would invent truth.
std::optional<Rigid3> TruthAt(const std::vector<StampedPose>& truth, std::int64_t time_ns);

// A frame of a list and its true pose.
struct FrameWithTruth {
  FrameRecord frame;
  std::optional<Rigid3> truth;
};

// Numbers the frames' frame_idx from 0 in their order, and lists their truth.
void NumberFrames(std::vector<FrameWithTruth> all,
                  std::vector<FrameRecord>* frames,
                  std::vector<StampedPose>* truth);

// Keeps the cameras that the frames use, in the order of `cameras`, and renumbers the frames'
// camera_idx accordingly. So a camera that no frame uses does not influence artifacts made from the
// list.
std::vector<RgbdCamera> KeepUsedCameras(const std::vector<RgbdCamera>& cameras,
                                        std::vector<FrameRecord>* frames);

// Throws DataError when a camera has more than max_picture_mpx million pixels. A picture is decoded
// only if it has its camera's size, so this bounds the memory for decoding.
void CheckAreas(const std::vector<RgbdCamera>& cameras, double max_picture_mpx);

}  // namespace nightmap
