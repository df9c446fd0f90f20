// SPDX-License-Identifier: Apache-2.0
// Animations of drawings, as GIF.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

// Writes an animation of RGB images of one size that repeats for ever, in exactly their colors. All
// images together may have at most 256 colors; drawings without anti-aliasing do. Stores only the
// changes from image to image. Equal pixels give equal bytes. Throws DataError naming the file when
// there are more colors, no image, or images of several sizes, or when the file cannot be written.
void WriteGif(const std::filesystem::path& path,
              const std::vector<ColorImage>& images,
              double images_per_s);

}  // namespace nightmap
