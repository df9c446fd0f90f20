// SPDX-License-Identifier: Apache-2.0
// Procedural pictures of building materials and of wall decoration. All have 3 channels, tile
// without a seam (except posters and panels) and depend only on their arguments.
#pragma once

#include <cstdint>

#include "pipeline/io/image_io.h"

namespace nightmap {

enum class Paint {
  kPoster,     // shapes of several scales and lines of glyphs; unique per seed
  kPanel,      // sober notice board of rectangles and glyphs
  kBooks,      // book spines side by side
  kWood,       // grain along u
  kPlanks,     // parquet: planks of wood of different tones
  kBrick,      // running bond
  kTerrazzo,   // stone chips of many sizes
  kCarpet,     // noise at several scales
  kPlaster,    // nearly blank
  kWallpaper,  // irregular small motifs
  kCeiling,    // perforated tiles with joints
  kFabric,     // woven threads with blots
  kMottle,     // gray around 128, for multiplication onto another texture
};

// `size_px`: width and height, a power of two.
ColorImage PaintTexture(Paint paint, int size_px, std::uint64_t seed);

}  // namespace nightmap
