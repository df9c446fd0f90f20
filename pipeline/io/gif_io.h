// SPDX-License-Identifier: Apache-2.0
// Animations of drawings, as GIF.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

// An animation of RGB images of one size, repeated for ever, in exactly their colors: together they
// have at most 256, as drawings without smoothed edges do. Only what changes from image to image is
// stored. Equal pixels give equal bytes. Throws DataError naming the file when there are more
// colors, no image, images of several sizes, or the file cannot be written.
void WriteGif(const std::filesystem::path& path,
              const std::vector<ColorImage>& images,
              double images_per_s);

}  // namespace nightmap
