// SPDX-License-Identifier: Apache-2.0
// Frames of video files that OpenCV reads.
#pragma once

#include <cstdint>
#include <filesystem>

#include "pipeline/io/image_io.h"

namespace nightmap::media {

// As the functions of these names in image_io.h.
ColorImage ReadVideoFrame(const std::filesystem::path& video, int frame_idx);
VideoInfo InspectVideo(const std::filesystem::path& path);
std::int64_t NumDecodedVideoFrames();

}  // namespace nightmap::media
