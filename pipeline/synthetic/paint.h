// SPDX-License-Identifier: Apache-2.0
// Procedural pictures of building materials and of things hung on walls. All are 3-channel, repeat
// without a seam (posters and panels excepted) and depend on nothing but their arguments.
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
  kMottle,     // gray around 128, to be multiplied onto another texture
};

// `size_px`: width and height, a power of two.
ColorImage PaintTexture(Paint paint, int size_px, std::uint64_t seed);

}  // namespace nightmap
