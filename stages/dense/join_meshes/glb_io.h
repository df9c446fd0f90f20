// SPDX-License-Identifier: Apache-2.0
// Meshes as glTF 2.0 in one binary file (GLB), which browsers, Blender, Unity and Unreal open.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>

#include "pipeline/dense/mesh_io.h"

namespace nightmap {

// Same interface as MeshPlyWriter. glTF has y up and x right: (x, y, z) of the map is (x, z, -y)
// there, in metres. Colors are linear there, not sRGB as in pictures; the material is unlit, since
// the colors have the light of the building, and seen from both sides. Throws DataError naming the
// remedy for a mesh of 4 GiB or more, which the format cannot hold.
class GlbWriter {
 public:
  GlbWriter(const std::filesystem::path& path,
            const MeshSize& size,
            const Eigen::AlignedBox3f& box_in_map);
  void Add(const MeshVertex& vertex);
  void Add(const Triangle& triangle);
  void Close();

 private:
  std::filesystem::path path_;
  std::ofstream stream_;
};

}  // namespace nightmap
