// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_meshes/glb_parts.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

std::array<std::uint16_t, 256> MakeLinear() {
  std::array<std::uint16_t, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    const double value = static_cast<double>(i) / 255;
    const double part = value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
    linear[i] = static_cast<std::uint16_t>(std::lround(65535 * part));
  }
  return linear;
}

}  // namespace

Eigen::Vector3f InGltf(const Eigen::Vector3f& v) { return {v.x(), v.z(), -v.y()}; }

GlbJson GlbNumbers(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

std::uint16_t LinearColor(std::uint8_t srgb) {
  static const std::array<std::uint16_t, 256> kLinear = MakeLinear();
  return kLinear[srgb];
}

GlbJson GlbScene(std::size_t num_bytes) {
  return {
      {"asset",
       {{"version", "2.0"},
        {"generator", "nightmap"},
        {"extras",
         {{"units", "metres"}, {"up", "y"}, {"map_xyz", "x, -z, y of this file; z is up there"}}}}},
      {"extensionsUsed", {"KHR_materials_unlit"}},
      {"scene", 0},
      {"scenes", GlbJson::array({{{"nodes", {0}}}})},
      {"nodes", GlbJson::array({{{"name", "map"}, {"mesh", 0}}})},
      {"meshes", GlbJson::array({{{"primitives", GlbJson::array()}}})},
      {"materials", GlbJson::array()},
      {"accessors", GlbJson::array()},
      {"bufferViews", GlbJson::array()},
      {"buffers", GlbJson::array({{{"byteLength", num_bytes}}})}};
}

GlbJson GlbMaterial() {
  return {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
          {"doubleSided", true},
          {"extensions", {{"KHR_materials_unlit", GlbJson::object()}}}};
}

void BeginGlb(const std::filesystem::path& path,
              const GlbJson& description,
              std::size_t num_bytes,
              const std::string& remedy,
              std::ofstream& stream) {
  std::string json = description.dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::size_t total = 12 + 8 + json.size() + 8 + num_bytes;
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    throw DataError(
        "{}: it would have {} bytes, and a GLB ends at 4 GiB; {}", path.string(), total, remedy);
  }
  stream.open(path, std::ios::binary | std::ios::trunc);
  const auto number = [&](std::size_t value) {
    const auto word = static_cast<std::uint32_t>(value);
    stream.write(reinterpret_cast<const char*>(&word), sizeof(word));
  };
  stream << "glTF";
  number(2);
  number(total);
  number(json.size());
  stream << "JSON" << json;
  number(num_bytes);
  stream.write("BIN", 4);  // with the zero behind it
}

void CloseGlb(const std::filesystem::path& path, std::ofstream& stream) {
  stream.close();
  if (!stream) {
    throw DataError("{}: cannot write: {}; free space on that disk and run again",
                    path.string(),
                    std::strerror(errno));
  }
}

}  // namespace nightmap
