// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_meshes/join_meshes.h"

#include <bit>
#include <limits>
#include <unordered_map>

#include "pipeline/base/error.h"
#include "pipeline/base/union_find.h"

namespace nightmap {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

using PositionBits = std::array<std::uint32_t, 3>;

PositionBits BitsOf(const MeshVertex& vertex) {
  const Eigen::Vector3f& p = vertex.position_in_map;
  return {std::bit_cast<std::uint32_t>(p.x()),
          std::bit_cast<std::uint32_t>(p.y()),
          std::bit_cast<std::uint32_t>(p.z())};
}

struct HashOfBits {
  std::size_t operator()(const PositionBits& bits) const {
    std::uint64_t hash = 0;
    for (const std::uint32_t word : bits) hash = (hash ^ word) * 0x9E3779B97F4A7C15U;
    return hash ^ hash >> 32;
  }
};

// A vertex that tiles share.
struct SeamVertex {
  std::size_t component = 0;    // the first that has it
  std::uint32_t index = kNone;  // in the joined mesh
};

class MeshJoin {
 public:
  MeshJoin(std::size_t num_tiles, const TileMeshSource& load) : load_(load) {
    for (std::size_t tile = 0; tile < num_tiles; ++tile) Survey(load(tile));
  }

  JoinedMesh Choose(double min_component_m2);
  void Write(const MeshSink& sink);

 private:
  struct Part {  // a component of a tile
    MeshComponent component;
    Eigen::AlignedBox3f box_in_map;
    bool is_kept = false;
  };

  void Survey(const TileMesh& mesh);
  // Calls use(part, mesh, first vertex, first triangle) for the kept parts of a tile, the first of
  // which in parts_ is first_part.
  template <typename Use>
  void ForKept(const TileMesh& mesh, std::size_t first_part, const Use& use) const;
  // Gives the vertices of the kept parts their indices in the joined mesh; num_vertices counts them
  // on. Calls add(vertex) for those that no part before has.
  template <typename Add>
  std::vector<std::uint32_t> Number(const TileMesh& mesh,
                                    std::size_t first_part,
                                    std::uint32_t& num_vertices,
                                    const Add& add);

  const TileMeshSource& load_;
  std::vector<std::size_t> first_parts_;  // of each tile
  std::vector<Part> parts_;
  std::unordered_map<PositionBits, SeamVertex, HashOfBits> seam_;
  std::vector<std::pair<std::size_t, std::size_t>> joined_;  // parts that share a vertex
};

void MeshJoin::Survey(const TileMesh& mesh) {
  first_parts_.push_back(parts_.size());
  std::size_t vertex = 0;
  for (const MeshComponent& component : mesh.components) {
    Part& part = parts_.emplace_back(Part{component, {}, false});
    for (std::uint32_t i = 0; i < component.num_vertices; ++i, ++vertex) {
      part.box_in_map.extend(mesh.vertices[vertex].position_in_map);
      if (i >= component.num_seam_vertices) continue;
      const auto [seam, is_new] =
          seam_.insert({BitsOf(mesh.vertices[vertex]), {parts_.size() - 1, kNone}});
      const std::pair pair(seam->second.component, parts_.size() - 1);
      if (!is_new && (joined_.empty() || joined_.back() != pair)) joined_.push_back(pair);
    }
  }
}

JoinedMesh MeshJoin::Choose(double min_component_m2) {
  UnionFind sets(parts_.size());
  for (const auto& [a, b] : joined_) sets.Join(a, b);
  std::vector<double> area_m2(parts_.size());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    area_m2[sets.Find(i)] += parts_[i].component.area_m2;
  }
  JoinedMesh joined;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    part.is_kept = area_m2[sets.Find(i)] >= min_component_m2;
    if (sets.Find(i) == i) {
      ++(part.is_kept ? joined.num_components : joined.num_dropped_components);
    }
    if (!part.is_kept) continue;
    joined.size.num_vertices += part.component.num_vertices - part.component.num_seam_vertices;
    joined.size.num_triangles += part.component.num_triangles;
    joined.box_in_map.extend(part.box_in_map);
  }
  for (const auto& [bits, vertex] : seam_) {
    joined.size.num_vertices += parts_[vertex.component].is_kept ? 1 : 0;
  }
  for (std::size_t i = 0, tile = 0; tile < first_parts_.size(); ++tile) {
    auto& is_kept = joined.is_kept.emplace_back();
    const std::size_t end = tile + 1 < first_parts_.size() ? first_parts_[tile + 1] : parts_.size();
    for (; i < end; ++i) is_kept.push_back(parts_[i].is_kept);
  }
  return joined;
}

template <typename Use>
void MeshJoin::ForKept(const TileMesh& mesh, std::size_t first_part, const Use& use) const {
  std::size_t vertex = 0, triangle = 0;
  for (std::size_t i = 0; i < mesh.components.size(); ++i) {
    const Part& part = parts_[first_part + i];
    if (part.is_kept) use(part.component, vertex, triangle);
    vertex += part.component.num_vertices;
    triangle += part.component.num_triangles;
  }
}

template <typename Add>
std::vector<std::uint32_t> MeshJoin::Number(const TileMesh& mesh,
                                            std::size_t first_part,
                                            std::uint32_t& num_vertices,
                                            const Add& add) {
  std::vector<std::uint32_t> indices(mesh.vertices.size());
  ForKept(mesh, first_part, [&](const MeshComponent& component, std::size_t first, std::size_t) {
    for (std::uint32_t i = 0; i < component.num_vertices; ++i) {
      const MeshVertex& vertex = mesh.vertices[first + i];
      std::uint32_t index = num_vertices;
      if (i < component.num_seam_vertices) {
        SeamVertex& seam = seam_.at(BitsOf(vertex));
        if (seam.index == kNone) seam.index = num_vertices;
        index = seam.index;
      }
      indices[first + i] = index;
      if (index != num_vertices) continue;
      add(vertex);
      ++num_vertices;
    }
  });
  return indices;
}

void MeshJoin::Write(const MeshSink& sink) {
  std::uint32_t num_vertices = 0;
  for (std::size_t tile = 0; tile < first_parts_.size(); ++tile) {
    Number(load_(tile), first_parts_[tile], num_vertices, sink.vertex);
  }
  num_vertices = 0;
  for (std::size_t tile = 0; tile < first_parts_.size(); ++tile) {
    const TileMesh mesh = load_(tile);
    const auto indices = Number(mesh, first_parts_[tile], num_vertices, [](const MeshVertex&) {});
    ForKept(mesh,
            first_parts_[tile],
            [&](const MeshComponent& component, std::size_t, std::size_t first) {
              for (std::uint32_t i = 0; i < component.num_triangles; ++i) {
                const auto& [a, b, c] = mesh.triangles[first + i];
                sink.triangle({indices[a], indices[b], indices[c]});
              }
            });
  }
}

}  // namespace

JoinedMesh RunJoinMeshes(const JoinMeshesOptions& options,
                         std::size_t num_tiles,
                         const TileMeshSource& load,
                         const MeshSink& sink) {
  MeshJoin join(num_tiles, load);
  const JoinedMesh joined = join.Choose(options.min_component_m2);
  if (joined.size.num_triangles == 0) {
    throw DataError(
        "no surface is left of the meshes of {} tiles ({} parts are smaller than {} m2); lower "
        "join_meshes.min_component_m2, or raise mesh.max_gap_voxels if the cloud is sparse",
        num_tiles,
        joined.num_dropped_components,
        options.min_component_m2);
  }
  if (joined.size.num_vertices > std::numeric_limits<std::int32_t>::max()) {
    throw DataError("{} vertices are more than a PLY can number; raise mesh.cell_voxels",
                    joined.size.num_vertices);
  }
  sink.begin(joined);
  join.Write(sink);
  return joined;
}

}  // namespace nightmap
