// SPDX-License-Identifier: Apache-2.0
// ceiling_mosaic: one picture of the whole ceiling to the scale of the map, drawn like a map of the
// floor: as from above.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/image_io.h"

namespace nightmap {

struct CeilingMosaicOptions {
  OPTION(double, resolution_m, 0.01, {0.001, 1}, "edge of a pixel of the mosaic");
  OPTION(int, max_edge_px, 30000, {100, 100000},
         "largest edge of the mosaic; pixels of a wider ceiling are larger");
  OPTION(double, max_failed_ratio, 0.2, {0, 1},
         "fails when a larger share of the pictures cannot be read");
  REGISTER_OPTIONS();
};

struct CeilingView {
  Rigid3 map_from_camera;
  std::size_t frame = 0;
};

struct CeilingMosaicInput {
  Camera camera;
  std::vector<CeilingView> views;
  std::vector<Eigen::Vector3d> landmarks;  // m, in the map
  // Pixels of a frame, as the camera took them; throws DataError. Several threads may ask at once.
  std::function<ColorImage(std::size_t frame)> load;
};

// Column c, row r shows the ceiling at x = origin.x + (c + 0.5) resolution, y = origin.y + (height
// - r - 0.5) resolution of the map: x is right, y is up, as in maps of floors.
struct CeilingMosaic {
  ColorImage picture;                                // black where no view saw the ceiling
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // m, of the lower left corner
  double resolution_m = 0;
  double covered_m2 = 0;
  // Median, to 0.01, over the pixels that several views saw of the deviation of their brightness, 0
  // to 255: small where poses, heights and exposure agree.
  double median_deviation = 0;
  std::vector<std::string> skipped;  // views that cannot be read, and why
};

// Each pixel is the mean of all views of its point on the ceiling, whose weight falls from the
// middle of a view to its border, so that no seam shows. The height of the ceiling is that of the
// landmarks around (ceiling_heights.h). Blocks of the mosaic are made apart, with the views that
// reach them: memory is that of the mosaic and of a view per thread. Throws InputError of the port
// `map` without a landmark above the camera. Deterministic at any number of threads.
CeilingMosaic RunCeilingMosaic(const CeilingMosaicOptions& options,
                               const CeilingMosaicInput& input,
                               Progress& progress,
                               int num_threads);

}  // namespace nightmap
