// SPDX-License-Identifier: Apache-2.0
// What the EXIF part of a picture says of its lens.
#pragma once

#include <optional>

namespace nightmap {

// As stored. 0, and whatever is not a positive number: not known (writers put 0 there themselves).
struct ExifLens {
  double focal_35mm_mm = 0;  // FocalLengthIn35mmFilm: with the same diagonal field of view on film
  double focal_mm = 0;       // FocalLength
  double plane_pixels_per_unit = 0;  // FocalPlaneXResolution
  int plane_unit = 2;                // FocalPlaneResolutionUnit: 2 inch, 3 cm, 4 mm, 5 um
  double longer_side_px = 0;         // of PixelXDimension and PixelYDimension, as taken
};

// Focal length (px, of square pixels) of a picture of that size: by the 35 mm equivalent, which
// counts digital zoom in, else by focal length and sensor resolution. A picture that was made
// smaller since is understood, one that was cropped is not. Nothing when the lens is not known.
std::optional<double> FocalLength_px(const ExifLens& lens, int width, int height);

}  // namespace nightmap
