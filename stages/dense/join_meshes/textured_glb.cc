// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_meshes/textured_glb.h"

#include <fstream>

#include "pipeline/dense/raw_bytes.h"
#include "stages/dense/join_meshes/glb_parts.h"

namespace nightmap {
namespace {

// A position, and a place on the page or 16 bits per channel and opacity.
constexpr std::size_t kChartVertexBytes = 5 * sizeof(float);
static_assert(2 * sizeof(float) == 4 * sizeof(std::uint16_t));

// All charts of a tile on one page, or without one.
struct Group {
  std::int32_t page = TextureChart::kNoPage;
  MeshSize size;
  Eigen::AlignedBox3f box_in_map;
  std::size_t picture_bytes = 0;

  std::size_t PaddedPictureBytes() const { return (picture_bytes + 3) / 4 * 4; }
  std::size_t NumBytes() const {
    return size.num_vertices * kChartVertexBytes + size.num_triangles * sizeof(Triangle) +
           PaddedPictureBytes();
  }
};

// Calls use(chart, first vertex, first triangle) for the charts on the page that are kept.
template <typename Use>
void ForCharts(const TileTexture& texture,
               const std::vector<bool>& is_kept,
               std::int32_t page,
               const Use& use) {
  std::size_t vertex = 0, triangle = 0;
  for (const TextureChart& chart : texture.charts) {
    if (chart.page == page && is_kept[static_cast<std::size_t>(chart.component)]) {
      use(chart, vertex, triangle);
    }
    vertex += static_cast<std::size_t>(chart.num_vertices);
    triangle += static_cast<std::size_t>(chart.num_triangles);
  }
}

std::vector<Group> GroupsOf(const TileMesh& mesh,
                            const TileTexture& texture,
                            const std::vector<bool>& is_kept) {
  std::vector<Group> groups;
  const auto num_pages = static_cast<std::int32_t>(texture.pages.size());
  for (std::int32_t page = TextureChart::kNoPage; page < num_pages; ++page) {
    Group group;
    group.page = page;
    ForCharts(texture, is_kept, page, [&](const TextureChart& chart, std::size_t first, auto) {
      const auto num_vertices = static_cast<std::size_t>(chart.num_vertices);
      group.size.num_vertices += num_vertices;
      group.size.num_triangles += static_cast<std::size_t>(chart.num_triangles);
      for (std::size_t i = first; i < first + num_vertices; ++i) {
        const auto vertex = static_cast<std::size_t>(texture.vertices[i].vertex);
        group.box_in_map.extend(mesh.vertices[vertex].position_in_map);
      }
    });
    if (page >= 0) group.picture_bytes = texture.pages[static_cast<std::size_t>(page)].size();
    if (group.size.num_triangles > 0) groups.push_back(group);
  }
  return groups;
}

// Adds what describes the group to the file; its bytes begin at `offset` of the buffer.
void Describe(const Group& group, std::size_t offset, GlbJson& file) {
  GlbJson &views = file["bufferViews"], &accessors = file["accessors"];
  const std::size_t view = views.size(), first = accessors.size();
  const std::size_t vertex_bytes = group.size.num_vertices * kChartVertexBytes;
  const std::size_t triangle_bytes = group.size.num_triangles * sizeof(Triangle);
  views.push_back({{"buffer", 0},
                   {"byteOffset", offset},
                   {"byteLength", vertex_bytes},
                   {"byteStride", kChartVertexBytes},
                   {"target", kGlbVertices}});
  views.push_back({{"buffer", 0},
                   {"byteOffset", offset + vertex_bytes},
                   {"byteLength", triangle_bytes},
                   {"target", kGlbIndices}});
  const Eigen::AlignedBox3f box =
      Eigen::AlignedBox3f(InGltf(group.box_in_map.min())).extend(InGltf(group.box_in_map.max()));
  accessors.push_back({{"bufferView", view},
                       {"componentType", kGlbFloat},
                       {"count", group.size.num_vertices},
                       {"type", "VEC3"},
                       {"min", GlbNumbers(box.min())},
                       {"max", GlbNumbers(box.max())}});
  const bool is_textured = group.page != TextureChart::kNoPage;
  GlbJson color{{"bufferView", view},
                {"byteOffset", 3 * sizeof(float)},
                {"componentType", is_textured ? kGlbFloat : kGlbUint16},
                {"count", group.size.num_vertices},
                {"type", is_textured ? "VEC2" : "VEC4"}};
  if (!is_textured) color["normalized"] = true;
  accessors.push_back(color);
  accessors.push_back({{"bufferView", view + 1},
                       {"componentType", kGlbUint32},
                       {"count", 3 * group.size.num_triangles},
                       {"type", "SCALAR"}});
  GlbJson material = GlbMaterial();
  if (is_textured) {
    const std::size_t picture = file["images"].size();
    file["images"].push_back({{"bufferView", view + 2}, {"mimeType", "image/jpeg"}});
    file["textures"].push_back({{"source", picture}});
    material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", picture}};
    views.push_back({{"buffer", 0},
                     {"byteOffset", offset + vertex_bytes + triangle_bytes},
                     {"byteLength", group.picture_bytes}});
  }
  file["meshes"][0]["primitives"].push_back(
      {{"attributes", {{"POSITION", first}, {is_textured ? "TEXCOORD_0" : "COLOR_0", first + 1}}},
       {"indices", first + 2},
       {"material", file["materials"].size()}});
  file["materials"].push_back(material);
}

void WriteVertex(const MeshVertex& vertex,
                 const Eigen::Vector2f& uv,
                 bool is_textured,
                 std::ofstream& stream) {
  std::array<char, kChartVertexBytes> bytes{};
  char* to = bytes.data();
  const Eigen::Vector3f position = InGltf(vertex.position_in_map);
  for (int axis = 0; axis < 3; ++axis) Put(position[axis], to);
  if (is_textured) {
    Put(uv.x(), to);
    Put(uv.y(), to);
  } else {
    for (const std::uint8_t channel : vertex.rgb) Put(LinearColor(channel), to);
    Put(std::uint16_t{65535}, to);
  }
  stream.write(bytes.data(), bytes.size());
}

void WriteGroup(const Group& group,
                const TileMesh& mesh,
                const TileTexture& texture,
                const std::vector<bool>& is_kept,
                std::ofstream& stream) {
  const bool is_textured = group.page != TextureChart::kNoPage;
  ForCharts(texture, is_kept, group.page, [&](const TextureChart& chart, std::size_t first, auto) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(chart.num_vertices); ++i) {
      const TextureVertex& vertex = texture.vertices[first + i];
      WriteVertex(
          mesh.vertices[static_cast<std::size_t>(vertex.vertex)], vertex.uv, is_textured, stream);
    }
  });
  std::uint32_t vertex = 0;
  ForCharts(texture, is_kept, group.page, [&](const TextureChart& chart, auto, std::size_t first) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(chart.num_triangles); ++i) {
      Triangle triangle = texture.triangles[first + i];
      for (std::uint32_t& corner : triangle) corner += vertex;
      stream.write(reinterpret_cast<const char*>(triangle.data()), sizeof(triangle));
    }
    vertex += static_cast<std::uint32_t>(chart.num_vertices);
  });
  if (!is_textured) return;
  std::string picture = texture.pages[static_cast<std::size_t>(group.page)];
  picture.resize(group.PaddedPictureBytes());
  stream << picture;
}

}  // namespace

TexturedSize WriteTexturedGlb(const std::filesystem::path& path,
                              const JoinedMesh& joined,
                              const TileMeshSource& load_mesh,
                              const TileTextureSource& load_texture) {
  const std::size_t num_tiles = joined.is_kept.size();
  std::vector<std::vector<Group>> groups(num_tiles);
  TexturedSize size;
  std::size_t num_bytes = 0;
  GlbJson file = GlbScene(0);
  for (std::size_t tile = 0; tile < num_tiles; ++tile) {
    const TileMesh mesh = load_mesh(tile);
    groups[tile] = GroupsOf(mesh, load_texture(tile, mesh), joined.is_kept[tile]);
    for (const Group& group : groups[tile]) {
      Describe(group, num_bytes, file);
      num_bytes += group.NumBytes();
      size.num_triangles += group.size.num_triangles;
      if (group.page == TextureChart::kNoPage) continue;
      size.num_textured_triangles += group.size.num_triangles;
      ++size.num_pages;
    }
  }
  file["buffers"][0]["byteLength"] = num_bytes;
  std::ofstream stream;
  BeginGlb(path, file, num_bytes, "raise texture_mesh.texel_m", stream);
  for (std::size_t tile = 0; tile < num_tiles; ++tile) {
    const TileMesh mesh = load_mesh(tile);
    const TileTexture texture = load_texture(tile, mesh);
    for (const Group& group : groups[tile]) {
      WriteGroup(group, mesh, texture, joined.is_kept[tile], stream);
    }
  }
  CloseGlb(path, stream);
  return size;
}

}  // namespace nightmap
