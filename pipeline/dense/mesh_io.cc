// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/mesh_io.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/dense/raw_bytes.h"

namespace nightmap {
namespace {

constexpr std::size_t kVertexBytes = 6 * sizeof(float) + 3;
constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(std::uint32_t);
constexpr std::size_t kComponentBytes = 3 * sizeof(std::uint32_t) + sizeof(double);
constexpr std::string_view kEndOfHeader = "end_header\n";

std::string HeaderOf(std::string_view comment, const MeshSize& size, std::string_view more) {
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment {}, metres, map frame (z up)\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face {}\nproperty list uchar int vertex_indices\n{}{}",
      comment,
      size.num_vertices,
      size.num_triangles,
      more,
      kEndOfHeader);
}

std::string TileHeader(const MeshSize& size, std::size_t num_components) {
  const std::string component = fmt::format(
      "element component {}\nproperty uint num_vertices\nproperty uint num_seam_vertices\n"
      "property uint num_triangles\nproperty double area_m2\n",
      num_components);
  return HeaderOf("nightmap mesh of a tile, version 1", size, component);
}

[[noreturn]] void Refuse(const std::filesystem::path& path, const std::string& reason) {
  throw DataError("{}: {}; delete it and run make", path.string(), reason);
}

// The count after `element <name> ` of a header; 0 where there is none.
std::size_t CountIn(std::string_view header, std::string_view name) {
  const std::string before = fmt::format("\nelement {} ", name);
  const std::size_t at = header.find(before);
  if (at == std::string_view::npos) return 0;
  std::size_t count = 0;
  for (const char c : header.substr(at + before.size(), 12)) {
    if (c < '0' || c > '9') break;
    count = 10 * count + static_cast<std::size_t>(c - '0');
  }
  return count;
}

// Checks header and size; gives `mesh` its sizes. Returns where the vertices begin.
const char* CheckHeader(const std::filesystem::path& path, std::string_view bytes, TileMesh& mesh) {
  const std::size_t end = bytes.find(kEndOfHeader);
  if (end == std::string_view::npos) Refuse(path, "not a PLY file of the mesh of a tile");
  const std::string_view header = bytes.substr(0, end + kEndOfHeader.size());
  const MeshSize size{CountIn(header, "vertex"), CountIn(header, "face")};
  const std::size_t num_components = CountIn(header, "component");
  if (header != TileHeader(size, num_components)) {
    Refuse(path, "not a PLY file of the mesh of a tile, version 1");
  }
  const std::size_t needed = size.num_vertices * kVertexBytes + size.num_triangles * kFaceBytes +
                             num_components * kComponentBytes;
  if (bytes.size() - header.size() != needed) {
    Refuse(
        path,
        fmt::format(
            "its elements need {} bytes, the file holds {}", needed, bytes.size() - header.size()));
  }
  mesh.vertices.resize(size.num_vertices);
  mesh.triangles.resize(size.num_triangles);
  mesh.components.resize(num_components);
  return bytes.data() + header.size();
}

void CheckComponents(const std::filesystem::path& path, const TileMesh& mesh) {
  std::size_t vertex = 0, triangle = 0;
  for (const MeshComponent& component : mesh.components) {
    const std::size_t first = vertex;
    vertex += component.num_vertices;
    if (component.num_seam_vertices > component.num_vertices || !(component.area_m2 >= 0) ||
        !std::isfinite(component.area_m2) || vertex > mesh.vertices.size() ||
        triangle + component.num_triangles > mesh.triangles.size()) {
      Refuse(path, "a component does not fit the vertices and triangles");
    }
    for (const std::size_t end = triangle + component.num_triangles; triangle < end; ++triangle) {
      for (const std::uint32_t index : mesh.triangles[triangle]) {
        if (index >= first && index < vertex) continue;
        Refuse(path, fmt::format("face {}: vertex {} is out of range", triangle, index));
      }
    }
  }
  if (vertex != mesh.vertices.size() || triangle != mesh.triangles.size()) {
    Refuse(path, "its components have fewer vertices or triangles than it has");
  }
}

}  // namespace

MeshPlyWriter::MeshPlyWriter(const std::filesystem::path& path, const std::string& header)
    : path_(path), stream_(path, std::ios::binary | std::ios::trunc) {
  stream_ << header;
}

MeshPlyWriter::MeshPlyWriter(const std::filesystem::path& path, const MeshSize& size)
    : MeshPlyWriter(path, HeaderOf("nightmap mesh", size, "")) {}

void MeshPlyWriter::Add(const MeshVertex& vertex) {
  std::array<char, kVertexBytes> bytes{};
  char* to = bytes.data();
  for (int axis = 0; axis < 3; ++axis) Put(vertex.position_in_map[axis], to);
  for (int axis = 0; axis < 3; ++axis) Put(vertex.normal_in_map[axis], to);
  Put(vertex.rgb, to);
  stream_.write(bytes.data(), bytes.size());
}

void MeshPlyWriter::Add(const Triangle& triangle) {
  std::array<char, kFaceBytes> bytes{3};
  char* to = bytes.data() + 1;
  Put(triangle, to);
  stream_.write(bytes.data(), bytes.size());
}

void MeshPlyWriter::Close() {
  stream_.close();
  if (!stream_) {
    throw DataError("{}: cannot write: {}; free space on that disk and run again",
                    path_.string(),
                    std::strerror(errno));
  }
}

void WriteTileMesh(const std::filesystem::path& path, const TileMesh& mesh) {
  const MeshSize size{mesh.vertices.size(), mesh.triangles.size()};
  MeshPlyWriter writer(path, TileHeader(size, mesh.components.size()));
  for (const MeshVertex& vertex : mesh.vertices) writer.Add(vertex);
  for (const Triangle& triangle : mesh.triangles) writer.Add(triangle);
  for (const MeshComponent& component : mesh.components) {
    std::array<char, kComponentBytes> bytes{};
    char* to = bytes.data();
    Put(component.num_vertices, to);
    Put(component.num_seam_vertices, to);
    Put(component.num_triangles, to);
    Put(component.area_m2, to);
    writer.stream_.write(bytes.data(), bytes.size());
  }
  writer.Close();
}

TileMesh ReadTileMesh(const std::filesystem::path& path) {
  const std::string file = ReadFile(path);
  TileMesh mesh;
  const char* from = CheckHeader(path, file, mesh);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    MeshVertex& vertex = mesh.vertices[i];
    for (int axis = 0; axis < 3; ++axis) Take(from, vertex.position_in_map[axis]);
    for (int axis = 0; axis < 3; ++axis) Take(from, vertex.normal_in_map[axis]);
    Take(from, vertex.rgb);
    if (!vertex.position_in_map.allFinite() || !vertex.normal_in_map.allFinite()) {
      Refuse(path, fmt::format("vertex {} is not finite", i));
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (*from++ != 3) Refuse(path, fmt::format("face {} is no triangle", i));
    Take(from, mesh.triangles[i]);
  }
  for (MeshComponent& component : mesh.components) {
    Take(from, component.num_vertices);
    Take(from, component.num_seam_vertices);
    Take(from, component.num_triangles);
    Take(from, component.area_m2);
  }
  CheckComponents(path, mesh);
  return mesh;
}

}  // namespace nightmap
