// SPDX-License-Identifier: Apache-2.0
// Writes a whole landmark map as one region.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/io/landmarks_io.h"

namespace nightmap {

inline void WriteLandmarks(const std::filesystem::path& path,
                           const LandmarkMap& map,
                           const std::string& config) {
  LandmarksWriter writer(path, map, config);
  writer.Write(Rectangle{}, map);
  writer.Close();
}

}  // namespace nightmap
