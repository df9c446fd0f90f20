// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_clouds/pcd_io.h"

#include <bit>
#include <cerrno>
#include <cstring>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

static_assert(std::endian::native == std::endian::little, "a binary PCD is little-endian");

// Layout in the file.
struct PcdPoint {
  std::array<float, 3> position;
  std::array<float, 3> normal;
  std::uint32_t rgb;
  std::uint32_t label;
};
static_assert(sizeof(PcdPoint) == 32);

}  // namespace

PcdWriter::PcdWriter(const std::filesystem::path& path, std::size_t num_points)
    : path_(path), stream_(path, std::ios::binary | std::ios::trunc) {
  stream_ << "# .PCD v0.7 - nightmap point cloud, metres, map frame (z up)\nVERSION 0.7\n"
             "FIELDS x y z normal_x normal_y normal_z rgb label\nSIZE 4 4 4 4 4 4 4 4\n"
             "TYPE F F F F F F F U\nCOUNT 1 1 1 1 1 1 1 1\nWIDTH "
          << num_points << "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " << num_points
          << "\nDATA binary\n";
}

void PcdWriter::Add(const CloudPoint& point) {
  PcdPoint bytes{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bytes.position[axis] = point.position_in_map[static_cast<Eigen::Index>(axis)];
    bytes.normal[axis] = point.normal_in_map[static_cast<Eigen::Index>(axis)];
    bytes.rgb = bytes.rgb << 8 | point.rgb[axis];
  }
  bytes.label = point.label;
  stream_.write(reinterpret_cast<const char*>(&bytes), sizeof(bytes));
}

void PcdWriter::Close() {
  stream_.close();
  if (!stream_) {
    throw DataError("{}: cannot write: {}; free space on that disk and run again",
                    path_.string(),
                    std::strerror(errno));
  }
}

}  // namespace nightmap
