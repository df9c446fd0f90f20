// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_mosaic/mosaic_files.h"

#include <fmt/format.h>

namespace nightmap {

std::string MosaicToWorldFile(const CeilingMosaic& mosaic) {
  const double half_m = 0.5 * mosaic.resolution_m;
  return fmt::format("{0:.9f}\n0\n0\n-{0:.9f}\n{1:.9f}\n{2:.9f}\n",
                     mosaic.resolution_m,
                     mosaic.origin.x() + half_m,
                     mosaic.origin.y() + mosaic.picture.height * mosaic.resolution_m - half_m);
}

std::string MosaicToYaml(const CeilingMosaic& mosaic, const std::string& image_name) {
  return fmt::format("image: {}\nresolution: {:.9f}\norigin: [{:.9f}, {:.9f}, 0.0]\n",
                     image_name,
                     mosaic.resolution_m,
                     mosaic.origin.x(),
                     mosaic.origin.y());
}

}  // namespace nightmap
