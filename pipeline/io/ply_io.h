// SPDX-License-Identifier: Apache-2.0
// Point clouds as binary little-endian PLY, which CloudCompare, MeshLab and PCL open.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace nightmap {

struct CloudPoint {
  Eigen::Vector3f position_in_map = Eigen::Vector3f::Zero();  // metres
  Eigen::Vector3f normal_in_map = Eigen::Vector3f::Zero();    // unit, to the side it was seen from
  std::array<std::uint8_t, 3> rgb{};
  std::uint16_t label = 0;  // class of the semantic labels; 0 = none
};

// One vertex a point: float x y z nx ny nz, uchar red green blue, ushort label. Equal points give
// equal bytes. Throws DataError naming the file.
void WritePly(const std::filesystem::path& path, const std::vector<CloudPoint>& points);

// Reads what WritePly wrote. Throws DataError naming the file on another layout, a size that does
// not agree with the number of points, or NaN.
std::vector<CloudPoint> ReadPly(const std::filesystem::path& path);

}  // namespace nightmap
