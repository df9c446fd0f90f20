// SPDX-License-Identifier: Apache-2.0
// Meshes of triangles as binary little-endian PLY, which MeshLab, CloudCompare and Blender open.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace nightmap {

struct MeshVertex {
  Eigen::Vector3f position_in_map = Eigen::Vector3f::Zero();  // metres
  Eigen::Vector3f normal_in_map = Eigen::Vector3f::Zero();    // unit length, towards the seen side
  std::array<std::uint8_t, 3> rgb{};
};

// Indices of its vertices, counterclockwise from the seen side.
using Triangle = std::array<std::uint32_t, 3>;

// Triangles of a tile that hang together. Its vertices and triangles follow those of the component
// before it; vertices on seams, which a neighbouring tile may have too, are the first of them.
struct MeshComponent {
  std::uint32_t num_vertices = 0;
  std::uint32_t num_seam_vertices = 0;
  std::uint32_t num_triangles = 0;
  double area_m2 = 0;  // a multiple of 2^-30, so that sums do not depend on their order
};

struct TileMesh {
  std::vector<MeshComponent> components;
  std::vector<MeshVertex> vertices;
  std::vector<Triangle> triangles;
};

struct MeshSize {
  std::size_t num_vertices = 0;
  std::size_t num_triangles = 0;
};

// Writes a mesh piece by piece: exactly as many vertices and then triangles as `size` says, then
// Close. Vertices are float x y z nx ny nz, uchar red green blue; faces a list uchar int
// vertex_indices. Throws DataError naming the file and the system's reason, such as a full disk.
class MeshPlyWriter {
 public:
  MeshPlyWriter(const std::filesystem::path& path, const MeshSize& size);
  void Add(const MeshVertex& vertex);
  void Add(const Triangle& triangle);
  void Close();

 private:
  friend void WriteTileMesh(const std::filesystem::path& path, const TileMesh& mesh);
  MeshPlyWriter(const std::filesystem::path& path, const std::string& header);

  std::filesystem::path path_;
  std::ofstream stream_;
};

// The same file, with the components as a third element. Equal meshes give equal bytes.
void WriteTileMesh(const std::filesystem::path& path, const TileMesh& mesh);

// Throws DataError naming the file on another layout or version, a size that does not match the
// counts, NaN, or an index out of its component.
TileMesh ReadTileMesh(const std::filesystem::path& path);

}  // namespace nightmap
