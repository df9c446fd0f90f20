// SPDX-License-Identifier: Apache-2.0
// Point clouds in PCL's own format, PCD 0.7, binary.
#pragma once

#include <filesystem>
#include <fstream>

#include "pipeline/dense/ply_io.h"

namespace nightmap {

// Fields x y z normal_x normal_y normal_z rgb label, named as in pcl::PointXYZ, PointNormal,
// PointXYZRGBNormal and PointXYZL. Each has 4 bytes; the color is packed as 0x00RRGGBB. Same
// interface as PlyWriter.
class PcdWriter {
 public:
  PcdWriter(const std::filesystem::path& path, std::size_t num_points);
  void Add(const CloudPoint& point);
  void Close();

 private:
  std::filesystem::path path_;
  std::ofstream stream_;
};

}  // namespace nightmap
