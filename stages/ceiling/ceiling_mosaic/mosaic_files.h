// SPDX-License-Identifier: Apache-2.0
// Files that tell where a mosaic lies in the map.
#pragma once

#include <string>

#include "stages/ceiling/ceiling_mosaic/ceiling_mosaic.h"

namespace nightmap {

// The mosaic's place: six lines of an ESRI world file, and YAML as of maps of floors.
std::string MosaicToWorldFile(const CeilingMosaic& mosaic);
std::string MosaicToYaml(const CeilingMosaic& mosaic, const std::string& image_name);

}  // namespace nightmap
