// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_meshes/glb_io.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/dense/raw_bytes.h"

namespace nightmap {
namespace {

using Json = nlohmann::ordered_json;

// Positions, normals and colors of a vertex follow each other; 16 bits per channel and opacity.
constexpr std::size_t kVertexBytes = 2 * 3 * sizeof(float) + 4 * sizeof(std::uint16_t);
constexpr std::size_t kTriangleBytes = sizeof(Triangle);
constexpr int kFloat = 5126, kUint16 = 5123, kUint32 = 5125;  // names of OpenGL
constexpr int kVertices = 34962, kIndices = 34963;

Eigen::Vector3f InGltf(const Eigen::Vector3f& v) { return {v.x(), v.z(), -v.y()}; }

// The linear value of each sRGB value (IEC 61966-2-1), 0 to 65535.
std::array<std::uint16_t, 256> MakeLinear() {
  std::array<std::uint16_t, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const double value = static_cast<double>(i) / 255;
    const double part = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    linear[i] = static_cast<std::uint16_t>(std::lround(65535 * part));
  }
  return linear;
}

Json Numbers(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

Json Description(const MeshSize& size, const Eigen::AlignedBox3f& box_in_map) {
  const std::size_t vertex_bytes = size.num_vertices * kVertexBytes;
  const std::size_t triangle_bytes = size.num_triangles * kTriangleBytes;
  const Eigen::AlignedBox3f box =
      Eigen::AlignedBox3f(InGltf(box_in_map.min())).extend(InGltf(box_in_map.max()));
  const auto accessor = [](int view, std::size_t offset, int type, std::size_t count) {
    return Json{
        {"bufferView", view}, {"byteOffset", offset}, {"componentType", type}, {"count", count}};
  };
  Json position = accessor(0, 0, kFloat, size.num_vertices);
  position.update({{"type", "VEC3"}, {"min", Numbers(box.min())}, {"max", Numbers(box.max())}});
  Json normal = accessor(0, 12, kFloat, size.num_vertices);
  normal["type"] = "VEC3";
  Json color = accessor(0, 24, kUint16, size.num_vertices);
  color.update({{"normalized", true}, {"type", "VEC4"}});
  Json indices = accessor(1, 0, kUint32, 3 * size.num_triangles);
  indices["type"] = "SCALAR";
  const Json primitive{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"COLOR_0", 2}}},
                       {"indices", 3},
                       {"material", 0}};
  return {
      {"asset",
       {{"version", "2.0"},
        {"generator", "nightmap"},
        {"extras",
         {{"units", "metres"}, {"up", "y"}, {"map_xyz", "x, -z, y of this file; z is up there"}}}}},
      {"extensionsUsed", {"KHR_materials_unlit"}},
      {"scene", 0},
      {"scenes", Json::array({{{"nodes", {0}}}})},
      {"nodes", Json::array({{{"name", "map"}, {"mesh", 0}}})},
      {"meshes", Json::array({{{"primitives", Json::array({primitive})}}})},
      {"materials",
       Json::array({{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                     {"doubleSided", true},
                     {"extensions", {{"KHR_materials_unlit", Json::object()}}}}})},
      {"accessors", Json::array({position, normal, color, indices})},
      {"bufferViews",
       Json::array({{{"buffer", 0},
                     {"byteOffset", 0},
                     {"byteLength", vertex_bytes},
                     {"byteStride", kVertexBytes},
                     {"target", kVertices}},
                    {{"buffer", 0},
                     {"byteOffset", vertex_bytes},
                     {"byteLength", triangle_bytes},
                     {"target", kIndices}}})},
      {"buffers", Json::array({{{"byteLength", vertex_bytes + triangle_bytes}}})}};
}

}  // namespace

GlbWriter::GlbWriter(const std::filesystem::path& path,
                     const MeshSize& size,
                     const Eigen::AlignedBox3f& box_in_map)
    : path_(path), stream_(path, std::ios::binary | std::ios::trunc) {
  std::string json = Description(size, box_in_map).dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::size_t num_bytes =
      size.num_vertices * kVertexBytes + size.num_triangles * kTriangleBytes;
  const std::size_t total = 12 + 8 + json.size() + 8 + num_bytes;
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    throw DataError(
        "{}: {} vertices and {} triangles take {} bytes, and a GLB ends at 4 GiB; raise "
        "mesh.cell_voxels",
        path.string(),
        size.num_vertices,
        size.num_triangles,
        total);
  }
  const auto number = [this](std::size_t value) {
    const auto word = static_cast<std::uint32_t>(value);
    stream_.write(reinterpret_cast<const char*>(&word), sizeof(word));
  };
  stream_ << "glTF";
  number(2);
  number(total);
  number(json.size());
  stream_ << "JSON" << json;
  number(num_bytes);
  stream_.write("BIN", 4);  // with the zero behind it
}

void GlbWriter::Add(const MeshVertex& vertex) {
  static const std::array<std::uint16_t, 256> kLinear = MakeLinear();
  std::array<char, kVertexBytes> bytes{};
  char* to = bytes.data();
  const Eigen::Vector3f position = InGltf(vertex.position_in_map);
  const Eigen::Vector3f normal = InGltf(vertex.normal_in_map);
  for (int axis = 0; axis < 3; ++axis) Put(position[axis], to);
  for (int axis = 0; axis < 3; ++axis) Put(normal[axis], to);
  for (const std::uint8_t channel : vertex.rgb) Put(kLinear[channel], to);
  Put(std::uint16_t{65535}, to);
  stream_.write(bytes.data(), bytes.size());
}

void GlbWriter::Add(const Triangle& triangle) {
  stream_.write(reinterpret_cast<const char*>(triangle.data()), kTriangleBytes);
}

void GlbWriter::Close() {
  stream_.close();
  if (!stream_) {
    throw DataError("{}: cannot write: {}; free space on that disk and run again",
                    path_.string(),
                    std::strerror(errno));
  }
}

}  // namespace nightmap
