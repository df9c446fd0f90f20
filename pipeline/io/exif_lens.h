// SPDX-License-Identifier: Apache-2.0
// Lens data in the EXIF part of a picture.
#pragma once

#include <optional>

namespace nightmap {

// Values as stored. 0, or any value that is not a positive number, means not known (some writers
// put 0).
struct ExifLens {
  // FocalLengthIn35mmFilm: focal length on film with the same diagonal field of view.
  double focal_35mm_mm = 0;
  double focal_mm = 0;               // FocalLength
  double plane_pixels_per_unit = 0;  // FocalPlaneXResolution
  int plane_unit = 2;                // FocalPlaneResolutionUnit: 2 inch, 3 cm, 4 mm, 5 um
  double longer_side_px = 0;         // the longer of PixelXDimension and PixelYDimension, as taken
};

// Focal length (px, square pixels) of a picture of the given size: from the 35 mm equivalent, which
// includes digital zoom, else from focal length and sensor resolution. Correct for a picture that
// was scaled down since, wrong for a cropped one. Nothing when the lens is not known.
std::optional<double> FocalLength_px(const ExifLens& lens, int width, int height);

}  // namespace nightmap
