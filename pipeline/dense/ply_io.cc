// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/ply_io.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>
#include <tuple>

#include "pipeline/base/error.h"
#include "pipeline/dense/raw_bytes.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

constexpr std::size_t kUnlabelledBytes = 6 * sizeof(float) + 3;
constexpr std::string_view kBeforeCount =
    "ply\nformat binary_little_endian 1.0\n"
    "comment nightmap point cloud, metres, map frame (z up)\nelement vertex ";
constexpr std::string_view kAfterCount =
    "\nproperty float x\nproperty float y\nproperty float z\n"
    "property float nx\nproperty float ny\nproperty float nz\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\n";
constexpr std::string_view kUshortLabel = "property ushort label\nend_header\n";
constexpr std::string_view kUintAndScalarLabel =
    "property uint label\nproperty float scalar_label\nend_header\n";

std::string_view PropertiesOf(PlyLabels labels) {
  return labels == PlyLabels::kUshort ? kUshortLabel : kUintAndScalarLabel;
}

std::size_t PointBytes(PlyLabels labels) {
  return kUnlabelledBytes + (labels == PlyLabels::kUshort ? sizeof(std::uint16_t)
                                                          : sizeof(std::uint32_t) + sizeof(float));
}
constexpr std::size_t kMaxPointBytes = kUnlabelledBytes + sizeof(std::uint32_t) + sizeof(float);

CloudPoint TakePoint(const char* from, PlyLabels labels) {
  CloudPoint point;
  for (int axis = 0; axis < 3; ++axis) Take(from, point.position_in_map[axis]);
  for (int axis = 0; axis < 3; ++axis) Take(from, point.normal_in_map[axis]);
  Take(from, point.rgb);
  std::uint32_t label = 0;
  std::memcpy(&label, from, labels == PlyLabels::kUshort ? 2 : 4);
  point.label = static_cast<std::uint16_t>(label);
  return point;
}

}  // namespace

PlyWriter::PlyWriter(const std::filesystem::path& path, std::size_t num_points, PlyLabels labels)
    : path_(path), labels_(labels), stream_(path, std::ios::binary | std::ios::trunc) {
  stream_ << kBeforeCount << num_points << kAfterCount << PropertiesOf(labels);
}

void PlyWriter::Add(const CloudPoint& point) {
  std::array<char, kMaxPointBytes> bytes{};
  char* to = bytes.data();
  for (int axis = 0; axis < 3; ++axis) Put(point.position_in_map[axis], to);
  for (int axis = 0; axis < 3; ++axis) Put(point.normal_in_map[axis], to);
  Put(point.rgb, to);
  if (labels_ == PlyLabels::kUshort) {
    Put(point.label, to);
  } else {
    Put(std::uint32_t{point.label}, to);
    Put(static_cast<float>(point.label), to);
  }
  stream_.write(bytes.data(), to - bytes.data());
}

void PlyWriter::Close() {
  stream_.close();
  if (!stream_) {
    throw DataError("{}: cannot write: {}; free space on that disk and run again",
                    path_.string(),
                    std::strerror(errno));
  }
}

PlyReader::PlyReader(const std::filesystem::path& path)
    : path_(path), stream_(path, std::ios::binary) {
  if (!stream_) throw DataError("{}: cannot read: {}", path.string(), std::strerror(errno));
  ReadHeader();
  const auto begin = static_cast<std::uintmax_t>(stream_.tellg());
  const std::uintmax_t size = std::filesystem::file_size(path);
  if (size - begin != num_points_ * PointBytes(labels_)) {
    throw DataError("{}: {} points need {} bytes, the file holds {}; make it again",
                    path.string(),
                    num_points_,
                    num_points_ * PointBytes(labels_),
                    size - begin);
  }
}

void PlyReader::ReadHeader() {
  std::string before(kBeforeCount.size(), '\0'), count, after(kAfterCount.size() - 1, '\0');
  stream_.read(before.data(), static_cast<std::streamsize>(before.size()));
  std::getline(stream_, count);
  stream_.read(after.data(), static_cast<std::streamsize>(after.size()));
  std::string labels(kUshortLabel.size(), '\0');
  stream_.read(labels.data(), static_cast<std::streamsize>(labels.size()));
  if (stream_ && labels == kUintAndScalarLabel.substr(0, labels.size())) {
    labels_ = PlyLabels::kUintAndScalar;
    labels.resize(kUintAndScalarLabel.size());
    stream_.read(&labels[kUshortLabel.size()],
                 static_cast<std::streamsize>(labels.size() - kUshortLabel.size()));
  }
  if (!stream_ || before != kBeforeCount || after != kAfterCount.substr(1) ||
      labels != PropertiesOf(labels_)) {
    throw DataError("{}: not a PLY file with nightmap's properties; make it with point_cloud",
                    path_.string());
  }
  if (count.empty() || count.size() > 12 ||
      count.find_first_not_of("0123456789") != std::string::npos) {
    throw DataError("{}: element vertex: '{}' is not a count", path_.string(), count);
  }
  num_points_ = std::stoull(count);
}

std::optional<CloudPoint> PlyReader::Next() {
  if (num_read_ == num_points_) return std::nullopt;
  std::array<char, kMaxPointBytes> bytes{};
  stream_.read(bytes.data(), static_cast<std::streamsize>(PointBytes(labels_)));
  if (!stream_) throw DataError("{}: cannot read: {}", path_.string(), std::strerror(errno));
  const CloudPoint point = TakePoint(bytes.data(), labels_);
  if (!point.position_in_map.allFinite() || !point.normal_in_map.allFinite()) {
    throw DataError("{}: vertex {} is not finite; make it again", path_.string(), num_read_);
  }
  ++num_read_;
  return point;
}

void WritePly(const std::filesystem::path& path,
              const std::vector<CloudPoint>& points,
              PlyLabels labels) {
  PlyWriter writer(path, points.size(), labels);
  for (const CloudPoint& point : points) writer.Add(point);
  writer.Close();
}

std::vector<CloudPoint> ReadPly(const std::filesystem::path& path) {
  PlyReader reader(path);
  std::vector<CloudPoint> points;
  points.reserve(reader.NumPoints());
  while (const auto point = reader.Next()) points.push_back(*point);
  return points;
}

std::vector<CloudPoint> ReadPlyWithin(const std::vector<std::filesystem::path>& paths,
                                      const Rectangle& rectangle) {
  std::vector<CloudPoint> points;
  for (const auto& path : paths) {
    PlyReader reader(path);
    while (const auto point = reader.Next()) {
      if (rectangle.Contains(point->position_in_map.head<2>().cast<double>())) {
        points.push_back(*point);
      }
    }
  }
  return points;
}

bool ByVoxel(const CloudPoint& a, const CloudPoint& b, double voxel_size_m) {
  const auto key = [voxel_size_m](const CloudPoint& point) {
    const Eigen::Vector3f& p = point.position_in_map;
    const VoxelKey voxel = VoxelOf(p.cast<double>(), voxel_size_m);
    return std::tuple(PackVoxel(voxel), p.x(), p.y(), p.z());
  };
  return key(a) < key(b);
}

}  // namespace nightmap
