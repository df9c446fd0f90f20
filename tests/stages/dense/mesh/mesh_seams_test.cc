// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <iterator>
#include <set>

#include "tests/stages/dense/mesh/noisy_surfaces.h"
#include "tests/test_data.h"

namespace nightmap::mesh_seams_test {

using Corner = std::array<float, 3>;
using Corners = std::array<Corner, 3>;

// Positions of the corners of all triangles, each from its smallest corner on.
std::multiset<Corners> TrianglesOf(const TileMesh& mesh) {
  std::multiset<Corners> triangles;
  for (const Triangle& triangle : mesh.triangles) {
    Corners corners{};
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3f& p = mesh.vertices[triangle[i]].position_in_map;
      corners[i] = {p.x(), p.y(), p.z()};
    }
    std::rotate(corners.begin(), std::ranges::min_element(corners), corners.end());
    triangles.insert(corners);
  }
  return triangles;
}

// Two tiles that meet at a coordinate of x or y.
std::array<Rectangle, 2> Halves(int axis, double border_m) {
  std::array<Rectangle, 2> tiles{Rectangle{{-3, -3}, {3, 3}}, Rectangle{{-3, -3}, {3, 3}}};
  tiles[0].max_m[axis] = tiles[1].min_m[axis] = border_m;
  return tiles;
}

std::multiset<Corners> TrianglesOfTiles(const MeshCloud& cloud, int axis, double border_m) {
  std::multiset<Corners> triangles;
  for (const Rectangle& tile : Halves(axis, border_m)) {
    const Rectangle around = tile.Grown(MeshReach_m(MeshOptions(), kVoxel_m));
    MeshCloud near = cloud;
    std::erase_if(near.points, [&](const CloudPoint& point) {
      return !around.Contains(point.position_in_map.head<2>().cast<double>());
    });
    triangles.merge(TrianglesOf(MeshOf(near, tile)));
  }
  return triangles;
}

TEST(MeshSeams, TwoTilesHaveTheTrianglesOfOne) {
  const MeshCloud cloud = Ball().Cloud();
  const auto whole = TrianglesOf(MeshOf(cloud));
  EXPECT_EQ(TrianglesOfTiles(cloud, 0, 0.24), whole);  // on a border of cells
  EXPECT_EQ(TrianglesOfTiles(cloud, 0, 0.333), whole);
  EXPECT_EQ(TrianglesOfTiles(cloud, 1, -0.1), whole);
}

// Positions of all vertices, and of those said to be on a seam.
struct Vertices {
  std::set<Corner> all, on_seam;

  explicit Vertices(const TileMesh& mesh) {
    std::size_t first = 0;
    for (const MeshComponent& component : mesh.components) {
      for (std::size_t i = 0; i < component.num_vertices; ++i) {
        const Eigen::Vector3f& p = mesh.vertices[first + i].position_in_map;
        all.insert({p.x(), p.y(), p.z()});
        if (i < component.num_seam_vertices) on_seam.insert({p.x(), p.y(), p.z()});
      }
      first += component.num_vertices;
    }
  }
};

TEST(MeshSeams, VerticesOfTwoTilesAreOnTheSeam) {
  const MeshCloud cloud = Ball().Cloud();
  for (const int axis : {0, 1}) {
    const auto tiles = Halves(axis, 0.1);
    Vertices low(MeshOf(cloud, tiles[0])), high(MeshOf(cloud, tiles[1]));
    std::set<Corner> shared;
    std::ranges::set_intersection(low.all, high.all, std::inserter(shared, shared.end()));
    EXPECT_GT(shared.size(), 50U);
    EXPECT_EQ(low.on_seam, shared);
    EXPECT_EQ(high.on_seam, shared);
  }
}

}  // namespace nightmap::mesh_seams_test
