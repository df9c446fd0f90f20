// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/exif_lens.h"

#include <algorithm>
#include <cmath>

namespace nightmap {
namespace {

// The 35 mm equivalent is defined by the diagonal of the film (CIPA DCG-001), 36 x 24 mm.
const double kFilmDiagonal_mm = std::hypot(36.0, 24.0);

bool IsKnown(double value) { return std::isfinite(value) && value > 0; }

// 0: an unknown unit.
double UnitLength_mm(int plane_unit) {
  switch (plane_unit) {
    case 2:
      return 25.4;
    case 3:
      return 10;
    case 4:
      return 1;
    case 5:
      return 1e-3;
    default:
      return 0;
  }
}

}  // namespace

std::optional<double> FocalLength_px(const ExifLens& lens, int width, int height) {
  if (IsKnown(lens.focal_35mm_mm)) {
    return lens.focal_35mm_mm / kFilmDiagonal_mm * std::hypot(width, height);
  }
  const double unit_mm = UnitLength_mm(lens.plane_unit);
  if (!IsKnown(lens.focal_mm) || !IsKnown(lens.plane_pixels_per_unit) || unit_mm == 0) return {};
  const double scale =
      IsKnown(lens.longer_side_px) ? std::max(width, height) / lens.longer_side_px : 1;
  return lens.focal_mm * lens.plane_pixels_per_unit / unit_mm * scale;
}

}  // namespace nightmap
