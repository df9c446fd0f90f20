// SPDX-License-Identifier: Apache-2.0
// Colors of the classes.
#pragma once

#include <string>
#include <vector>

#include "pipeline/dense/octree_io.h"

namespace nightmap {

// Colors of `num_classes` classes. `texts` has a "#rrggbb" for each, or none: then the colors are
// those of PASCAL VOC (index 0 black). White, which OctoMap reads as no color, becomes #fffffe.
// Throws UsageError on another number of colors, or a text that is no color.
std::vector<Rgb> MakePalette(const std::vector<std::string>& texts, std::size_t num_classes);

}  // namespace nightmap
