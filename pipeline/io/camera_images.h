// SPDX-License-Identifier: Apache-2.0
// Reads images of a known camera.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/io/image_io.h"

namespace nightmap {

// Like ReadColorImage and ReadRawDepth, but the image must have the camera's size. Refuses a file
// whose header says otherwise before it decodes a pixel, because a few megabytes may unpack to
// gigabytes. The frames stage limits the area of every camera, but the file may have changed since.
// `num_bits`: that color pictures of 16 bits use. Throws DataError when a value needs more.
ColorImage ReadColorOf(const Camera& camera, const std::filesystem::path& path, int num_bits = 16);
// Depth may also be of floating-point values, of 16, 32 or 64 bits, and is as stored. Where nothing
// was measured it is 0, or of floats whatever is no positive number.
Image<float> ReadRawDepthOf(const Camera& camera, const std::filesystem::path& path);

// How sure the pixels of a depth picture are, in a picture of its size or a whole fraction of it.
LabelImage ReadConfidenceOf(const Camera& depth_camera, const std::filesystem::path& path);
// Throws DataError when a picture of confidence has another size.
void CheckConfidenceSize(const std::string& file,
                         int width,
                         int height,
                         const Camera& depth_camera);

}  // namespace nightmap
