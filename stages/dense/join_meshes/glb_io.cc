// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_meshes/glb_io.h"

#include <fmt/format.h>

#include "pipeline/dense/raw_bytes.h"
#include "stages/dense/join_meshes/glb_parts.h"

namespace nightmap {
namespace {

// Positions, normals and colors of a vertex follow each other; 16 bits per channel and opacity.
constexpr std::size_t kVertexBytes = 2 * 3 * sizeof(float) + 4 * sizeof(std::uint16_t);
constexpr std::size_t kTriangleBytes = sizeof(Triangle);

GlbJson Description(const MeshSize& size, const Eigen::AlignedBox3f& box_in_map) {
  const std::size_t vertex_bytes = size.num_vertices * kVertexBytes;
  const std::size_t triangle_bytes = size.num_triangles * kTriangleBytes;
  const Eigen::AlignedBox3f box =
      Eigen::AlignedBox3f(InGltf(box_in_map.min())).extend(InGltf(box_in_map.max()));
  const auto accessor = [](int view, std::size_t offset, int type, std::size_t count) {
    return GlbJson{
        {"bufferView", view}, {"byteOffset", offset}, {"componentType", type}, {"count", count}};
  };
  GlbJson position = accessor(0, 0, kGlbFloat, size.num_vertices);
  position.update(
      {{"type", "VEC3"}, {"min", GlbNumbers(box.min())}, {"max", GlbNumbers(box.max())}});
  GlbJson normal = accessor(0, 12, kGlbFloat, size.num_vertices);
  normal["type"] = "VEC3";
  GlbJson color = accessor(0, 24, kGlbUint16, size.num_vertices);
  color.update({{"normalized", true}, {"type", "VEC4"}});
  GlbJson indices = accessor(1, 0, kGlbUint32, 3 * size.num_triangles);
  indices["type"] = "SCALAR";
  GlbJson file = GlbScene(vertex_bytes + triangle_bytes);
  file["meshes"][0]["primitives"].push_back(
      {{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"COLOR_0", 2}}},
       {"indices", 3},
       {"material", 0}});
  file["materials"].push_back(GlbMaterial());
  file["accessors"] = GlbJson::array({position, normal, color, indices});
  file["bufferViews"] = GlbJson::array({{{"buffer", 0},
                                         {"byteOffset", 0},
                                         {"byteLength", vertex_bytes},
                                         {"byteStride", kVertexBytes},
                                         {"target", kGlbVertices}},
                                        {{"buffer", 0},
                                         {"byteOffset", vertex_bytes},
                                         {"byteLength", triangle_bytes},
                                         {"target", kGlbIndices}}});
  return file;
}

}  // namespace

GlbWriter::GlbWriter(const std::filesystem::path& path,
                     const MeshSize& size,
                     const Eigen::AlignedBox3f& box_in_map)
    : path_(path) {
  BeginGlb(path,
           Description(size, box_in_map),
           size.num_vertices * kVertexBytes + size.num_triangles * kTriangleBytes,
           fmt::format("{} vertices and {} triangles are too many: raise mesh.cell_voxels",
                       size.num_vertices,
                       size.num_triangles),
           stream_);
}

void GlbWriter::Add(const MeshVertex& vertex) {
  std::array<char, kVertexBytes> bytes{};
  char* to = bytes.data();
  const Eigen::Vector3f position = InGltf(vertex.position_in_map);
  const Eigen::Vector3f normal = InGltf(vertex.normal_in_map);
  for (int axis = 0; axis < 3; ++axis) Put(position[axis], to);
  for (int axis = 0; axis < 3; ++axis) Put(normal[axis], to);
  for (const std::uint8_t channel : vertex.rgb) Put(LinearColor(channel), to);
  Put(std::uint16_t{65535}, to);
  stream_.write(bytes.data(), bytes.size());
}

void GlbWriter::Add(const Triangle& triangle) {
  stream_.write(reinterpret_cast<const char*>(triangle.data()), kTriangleBytes);
}

void GlbWriter::Close() { CloseGlb(path_, stream_); }

}  // namespace nightmap
