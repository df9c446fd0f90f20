// SPDX-License-Identifier: Apache-2.0
// Parts of binary glTF 2.0 files (GLB) that meshes with and without pictures have.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

namespace nightmap {

using GlbJson = nlohmann::ordered_json;

constexpr int kGlbFloat = 5126, kGlbUint16 = 5123, kGlbUint32 = 5125;  // names of OpenGL
constexpr int kGlbVertices = 34962, kGlbIndices = 34963;

// (x, y, z) of the map in glTF, which has y up.
Eigen::Vector3f InGltf(const Eigen::Vector3f& v);
GlbJson GlbNumbers(const Eigen::Vector3f& v);

// The linear value of an sRGB value (IEC 61966-2-1), 0 to 65535, as glTF has colors of vertices.
std::uint16_t LinearColor(std::uint8_t srgb);

// A file of one mesh, yet without primitives, accessors and bufferViews, and with a buffer of
// num_bytes. Materials are as `glb_io.h` says.
GlbJson GlbScene(std::size_t num_bytes);
GlbJson GlbMaterial();

// Writes all of a file that is before the num_bytes of its buffer, a multiple of 4. Throws
// DataError naming the remedy when all would have 4 GiB or more.
void BeginGlb(const std::filesystem::path& path,
              const GlbJson& description,
              std::size_t num_bytes,
              const std::string& remedy,
              std::ofstream& stream);
// Throws DataError naming the file and the system's reason, such as a full disk.
void CloseGlb(const std::filesystem::path& path, std::ofstream& stream);

}  // namespace nightmap
