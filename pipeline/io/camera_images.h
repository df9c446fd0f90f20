// SPDX-License-Identifier: Apache-2.0
// Images of a known camera.
#pragma once

#include <filesystem>

#include "pipeline/io/image_io.h"

namespace nightmap {

// As ReadColorImage and ReadRawDepth, of an image that must have the camera's size. A file whose
// header says another is refused before a pixel is decoded: a few megabytes may unpack to
// gigabytes, and frames, which limits the area of every camera, saw what the file was then.
ColorImage ReadColorOf(const Camera& camera, const std::filesystem::path& path);
RawDepthImage ReadRawDepthOf(const Camera& camera, const std::filesystem::path& path);

}  // namespace nightmap
