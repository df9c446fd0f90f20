// SPDX-License-Identifier: Apache-2.0
// Point clouds as binary little-endian PLY, which CloudCompare, MeshLab and PCL open.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

#include "pipeline/geometry/rectangle.h"

namespace nightmap {

struct CloudPoint {
  Eigen::Vector3f position_in_map = Eigen::Vector3f::Zero();  // metres
  // Unit length, towards the side it was seen from.
  Eigen::Vector3f normal_in_map = Eigen::Vector3f::Zero();
  std::array<std::uint8_t, 3> rgb{};
  std::uint16_t label = 0;  // class of the semantic labels; 0 = none
};

// How a vertex holds its label. PCL reads `uint label` alone (PointXYZL); CloudCompare, MeshLab and
// others read the scalar field. The tiles and the joined cloud have no labels yet: 0 as `ushort`.
enum class PlyLabels { kUshort, kUintAndScalar };

// Writes a cloud point by point, so that it need not fit into memory. Needs exactly `num_points`
// calls of Add, then Close. Throws DataError naming the file and the system's reason, such as a
// full disk.
class PlyWriter {
 public:
  PlyWriter(const std::filesystem::path& path,
            std::size_t num_points,
            PlyLabels labels = PlyLabels::kUshort);
  void Add(const CloudPoint& point);
  void Close();

 private:
  std::filesystem::path path_;
  PlyLabels labels_;
  std::ofstream stream_;
};

// Reads a file of PlyWriter, in the same order. Throws DataError naming the file on another layout,
// a size that does not match the number of points, or NaN.
class PlyReader {
 public:
  explicit PlyReader(const std::filesystem::path& path);
  std::size_t NumPoints() const { return num_points_; }
  // The next point; nothing after the last.
  std::optional<CloudPoint> Next();

 private:
  void ReadHeader();

  std::filesystem::path path_;
  PlyLabels labels_ = PlyLabels::kUshort;
  std::ifstream stream_;
  std::size_t num_points_ = 0;
  std::size_t num_read_ = 0;
};

// One vertex per point: float x y z nx ny nz, uchar red green blue, then ushort label, or uint
// label and float scalar_label. Equal points give equal bytes.
void WritePly(const std::filesystem::path& path,
              const std::vector<CloudPoint>& points,
              PlyLabels labels = PlyLabels::kUshort);

std::vector<CloudPoint> ReadPly(const std::filesystem::path& path);

// The points of several files that lie in a rectangle of the map, in order.
std::vector<CloudPoint> ReadPlyWithin(const std::vector<std::filesystem::path>& paths,
                                      const Rectangle& rectangle);

// By voxel, then by position.
bool ByVoxel(const CloudPoint& a, const CloudPoint& b, double voxel_size_m);

}  // namespace nightmap
