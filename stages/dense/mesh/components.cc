// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/mesh/components.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "pipeline/base/union_find.h"

namespace nightmap {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// The number of each vertex's component, counted from the first vertex on; kNone without a
// triangle.
std::vector<std::uint32_t> NumberComponents(std::size_t num_vertices,
                                            const std::vector<Triangle>& triangles,
                                            std::vector<MeshComponent>& components) {
  UnionFind sets(num_vertices);
  std::vector<bool> is_used(num_vertices);
  for (const Triangle& triangle : triangles) {
    for (const std::uint32_t vertex : triangle) {
      is_used[vertex] = true;
      sets.Join(triangle[0], vertex);
    }
  }
  std::vector<std::uint32_t> component_of(num_vertices, kNone);
  for (std::size_t i = 0; i < num_vertices; ++i) {
    if (!is_used[i]) continue;
    const std::size_t first = sets.Find(i);  // the smallest of the set
    if (first == i) {
      component_of[i] = static_cast<std::uint32_t>(components.size());
      components.emplace_back();
    }
    component_of[i] = component_of[first];
  }
  return component_of;
}

double RoundedArea_m2(const std::vector<MeshVertex>& vertices, const Triangle& triangle) {
  const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
    return vertices[triangle[i]].position_in_map.cast<double>();
  };
  const double area_m2 = (corner(1) - corner(0)).cross(corner(2) - corner(0)).norm() / 2;
  return std::ldexp(std::nearbyint(std::ldexp(area_m2, 30)), -30);
}

}  // namespace

TileMesh GroupComponents(const std::vector<MeshVertex>& vertices,
                         const std::vector<bool>& is_on_seam,
                         const std::vector<Triangle>& triangles) {
  TileMesh mesh;
  const auto component_of = NumberComponents(vertices.size(), triangles, mesh.components);
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    if (component_of[i] == kNone) continue;
    order.push_back(i);
    MeshComponent& component = mesh.components[component_of[i]];
    ++component.num_vertices;
    component.num_seam_vertices += is_on_seam[i] ? 1 : 0;
  }
  std::ranges::sort(
      order, {}, [&](std::uint32_t i) { return std::tuple(component_of[i], !is_on_seam[i], i); });
  std::vector<std::uint32_t> new_index(vertices.size());
  for (const std::uint32_t i : order) {
    new_index[i] = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(vertices[i]);
  }
  mesh.triangles = triangles;
  std::ranges::stable_sort(
      mesh.triangles, {}, [&](const Triangle& triangle) { return component_of[triangle[0]]; });
  for (Triangle& triangle : mesh.triangles) {
    MeshComponent& component = mesh.components[component_of[triangle[0]]];
    ++component.num_triangles;
    component.area_m2 += RoundedArea_m2(vertices, triangle);
    for (std::uint32_t& vertex : triangle) vertex = new_index[vertex];
  }
  return mesh;
}

}  // namespace nightmap
