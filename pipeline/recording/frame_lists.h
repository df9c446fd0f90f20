// SPDX-License-Identifier: Apache-2.0
// What the lists of frames and of queries have in common.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/io/frames_io.h"

namespace nightmap {

// The pose of exactly that time, or interpolated between neighbours at most 0.1 s apart (rotation
// by slerp). A longer gap is a dropout: interpolating over it would invent the truth.
std::optional<Rigid3> TruthAt(const std::vector<StampedPose>& truth, std::int64_t time_ns);

// A frame of a list and its truth.
struct FrameWithTruth {
  FrameRecord frame;
  std::optional<Rigid3> truth;
};

// Gives the frames their frame_idx from 0 on, in their order, and lists their truth.
void NumberFrames(std::vector<FrameWithTruth> all,
                  std::vector<FrameRecord>* frames,
                  std::vector<StampedPose>* truth);

// The cameras that the frames have, in their order among `cameras`; makes the frames' camera_idx
// count in them. So a camera that no frame has stays out of what is made of the list.
std::vector<RgbdCamera> KeepUsedCameras(const std::vector<RgbdCamera>& cameras,
                                        std::vector<FrameRecord>* frames);

// Throws DataError when a camera has more than max_picture_mpx million pixels: a picture is decoded
// only when it has its camera's size, so this bounds what is decoded.
void CheckAreas(const std::vector<RgbdCamera>& cameras, double max_picture_mpx);

}  // namespace nightmap
