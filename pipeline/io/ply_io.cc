// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/ply_io.h"

#include <bit>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"

namespace nightmap {
namespace {

static_assert(std::endian::native == std::endian::little,
              "points are copied as they are in memory");

constexpr std::size_t kPointBytes = 6 * sizeof(float) + 3 + sizeof(std::uint16_t);
constexpr std::string_view kBeforeCount =
    "ply\nformat binary_little_endian 1.0\n"
    "comment nightmap point cloud, metres, map frame (z up)\nelement vertex ";
constexpr std::string_view kAfterCount =
    "\nproperty float x\nproperty float y\nproperty float z\n"
    "property float nx\nproperty float ny\nproperty float nz\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty ushort label\n"
    "end_header\n";

template <typename T>
void Append(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

template <typename T>
void Take(const char*& from, T& value) {
  std::memcpy(&value, from, sizeof(value));
  from += sizeof(value);
}

CloudPoint TakePoint(const char* from) {
  CloudPoint point;
  for (int axis = 0; axis < 3; ++axis) Take(from, point.position_in_map[axis]);
  for (int axis = 0; axis < 3; ++axis) Take(from, point.normal_in_map[axis]);
  Take(from, point.rgb);
  Take(from, point.label);
  return point;
}

// Number of points; the header is cut off `bytes`.
std::size_t TakeHeader(std::string_view& bytes, const std::filesystem::path& path) {
  const std::size_t count_end = bytes.find('\n', kBeforeCount.size());
  if (bytes.substr(0, kBeforeCount.size()) != kBeforeCount || count_end == std::string_view::npos ||
      bytes.substr(count_end, kAfterCount.size()) != kAfterCount) {
    throw DataError("{}: not a PLY file with nightmap's properties; make it with point_cloud",
                    path.string());
  }
  const std::string count(bytes.substr(kBeforeCount.size(), count_end - kBeforeCount.size()));
  bytes.remove_prefix(count_end + kAfterCount.size());
  if (count.empty() || count.size() > 12 ||
      count.find_first_not_of("0123456789") != std::string::npos) {
    throw DataError("{}: element vertex: '{}' is not a count", path.string(), count);
  }
  return std::stoull(count);
}

}  // namespace

void WritePly(const std::filesystem::path& path, const std::vector<CloudPoint>& points) {
  std::string bytes(kBeforeCount);
  bytes += std::to_string(points.size());
  bytes += kAfterCount;
  bytes.reserve(bytes.size() + points.size() * kPointBytes);
  for (const CloudPoint& point : points) {
    for (int axis = 0; axis < 3; ++axis) Append(point.position_in_map[axis], bytes);
    for (int axis = 0; axis < 3; ++axis) Append(point.normal_in_map[axis], bytes);
    Append(point.rgb, bytes);
    Append(point.label, bytes);
  }
  WriteFile(path, bytes);
}

std::vector<CloudPoint> ReadPly(const std::filesystem::path& path) {
  const std::string file = ReadFile(path);
  std::string_view bytes = file;
  const std::size_t num_points = TakeHeader(bytes, path);
  if (bytes.size() != num_points * kPointBytes) {
    throw DataError("{}: {} points need {} bytes, the file holds {}; make it again",
                    path.string(),
                    num_points,
                    num_points * kPointBytes,
                    bytes.size());
  }
  std::vector<CloudPoint> points;
  points.reserve(num_points);
  for (std::size_t i = 0; i < num_points; ++i) {
    points.push_back(TakePoint(bytes.data() + i * kPointBytes));
    if (!points.back().position_in_map.allFinite() || !points.back().normal_in_map.allFinite()) {
      throw DataError("{}: vertex {} is not finite; make it again", path.string(), i);
    }
  }
  return points;
}

}  // namespace nightmap
