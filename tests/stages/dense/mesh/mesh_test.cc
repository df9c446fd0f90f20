// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/mesh/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numbers>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/stages/dense/mesh/noisy_surfaces.h"
#include "tests/test_data.h"

namespace nightmap::mesh_test {

// How many triangles have each edge, in the direction in which they go along it.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> DirectedEdges(const TileMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& [a, b, c] : mesh.triangles) {
    for (const auto& edge : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) ++edges[edge];
  }
  return edges;
}

Eigen::Vector3d FacingOf(const TileMesh& mesh, const Triangle& triangle) {
  const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
    return mesh.vertices[triangle[i]].position_in_map.cast<double>();
  };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
}

double Area_m2(const TileMesh& mesh) {
  double area_m2 = 0;
  for (const MeshComponent& component : mesh.components) area_m2 += component.area_m2;
  return area_m2;
}

TEST(Mesh, ASphereIsClosedWithinMillimetresAndSeenFromOutside) {
  const Ball ball;
  const TileMesh mesh = MeshOf(ball.Cloud());
  ASSERT_EQ(mesh.components.size(), 1U);
  const double area_m2 = 4 * std::numbers::pi * ball.radius_m * ball.radius_m;
  EXPECT_NEAR(mesh.components[0].area_m2, area_m2, 0.01 * area_m2);
  for (const MeshVertex& vertex : mesh.vertices) {
    const Eigen::Vector3d out = vertex.position_in_map.cast<double>() - ball.centre;
    EXPECT_NEAR(out.norm(), ball.radius_m, 0.005);
    EXPECT_GT(vertex.normal_in_map.cast<double>().dot(out.normalized()), 0.99);
    EXPECT_EQ(vertex.rgb, (std::array<std::uint8_t, 3>{200, 100, 50}));
  }
  const auto edges = DirectedEdges(mesh);
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first}));
  }
  EXPECT_EQ(mesh.vertices.size() + mesh.triangles.size(), edges.size() / 2 + 2);  // Euler
  for (const Triangle& triangle : mesh.triangles) {
    const Eigen::Vector3d out =
        mesh.vertices[triangle[0]].position_in_map.cast<double>() - ball.centre;
    EXPECT_GT(FacingOf(mesh, triangle).dot(out), 0);
  }
}

TEST(Mesh, APlaneIsFlatterThanItsPoints) {
  const TileMesh mesh = MeshOf(Table(0));
  double sum_m2 = 0;
  for (const MeshVertex& vertex : mesh.vertices) {
    sum_m2 += std::pow(vertex.position_in_map.z() - 0.5, 2);
  }
  const double rms_m = std::sqrt(sum_m2 / static_cast<double>(mesh.vertices.size()));
  EXPECT_LT(rms_m, kNoise_m / 2);
  EXPECT_NEAR(mesh.components.at(0).area_m2, 4.0, 0.2);
}

TEST(Mesh, AHoleStaysAHole) {
  constexpr double kHole_m = 0.2;
  const TileMesh mesh = MeshOf(Table(kHole_m));
  const double gap_m = MeshOptions().max_gap_voxels * kVoxel_m;
  double nearest_m = 1;
  for (const MeshVertex& vertex : mesh.vertices) {
    nearest_m = std::min<double>(nearest_m, vertex.position_in_map.head<2>().norm());
  }
  EXPECT_GE(nearest_m, kHole_m - gap_m);
  EXPECT_LE(nearest_m, kHole_m + 2 * MeshOptions().cell_voxels * kVoxel_m);
}

// Both sides are seen, as those of a door: two sheets and nothing between or beside them.
TEST(Mesh, AThinWallHasTwoSides) {
  MeshCloud cloud = Table(0);
  for (const CloudPoint& point : Table(0).points) {
    CloudPoint& below = cloud.points.emplace_back(point);
    below.position_in_map.z() -= 0.05F;
    below.normal_in_map = -below.normal_in_map;
  }
  const TileMesh mesh = MeshOf(cloud);
  for (const MeshVertex& vertex : mesh.vertices) {
    const bool is_above = vertex.position_in_map.z() > 0.475F;
    EXPECT_EQ(is_above, vertex.normal_in_map.z() > 0);
    EXPECT_NEAR(vertex.position_in_map.z(), is_above ? 0.5 : 0.45, 0.02);
  }
  EXPECT_NEAR(Area_m2(mesh), 8.0, 0.4);
}

// From one sheet to the other the distance falls from positive to negative: it is zero between
// them.
TEST(Mesh, NothingIsBetweenAPanelAndTheWallBehindIt) {
  MeshCloud cloud = Table(0);
  for (const CloudPoint& point : Table(0).points) {
    cloud.points.emplace_back(point).position_in_map.z() -= 0.05F;
  }
  const TileMesh mesh = RunMesh({.cell_voxels = 1}, cloud, {}, 2);
  for (const MeshVertex& vertex : mesh.vertices) {
    const double z_m = vertex.position_in_map.z();
    EXPECT_LT(std::min(std::abs(z_m - 0.5), std::abs(z_m - 0.45)), 0.012);
  }
  EXPECT_NEAR(Area_m2(mesh), 8.0, 0.4);
}

TEST(Mesh, DependsNeitherOnThreadsNorOnTheOrderOfThePoints) {
  MeshCloud cloud = Ball().Cloud();
  TemporaryFolder folder;
  const auto bytes = [&](int num_threads) {
    WriteTileMesh(folder / "a.ply", MeshOf(cloud, {}, num_threads));
    return ReadFile(folder / "a.ply");
  };
  const std::string one = bytes(1);
  EXPECT_EQ(bytes(4), one);
  std::ranges::reverse(cloud.points);
  EXPECT_EQ(bytes(2), one);
}

TEST(Mesh, NoPointsNoTriangles) {
  const TileMesh mesh = MeshOf({{}, kVoxel_m});
  EXPECT_TRUE(mesh.vertices.empty());
  EXPECT_TRUE(mesh.triangles.empty());
  EXPECT_TRUE(mesh.components.empty());
}

TEST(Mesh, ComponentsAreApart) {
  MeshCloud cloud = Table(0);
  const Ball ball{{0, 0, 2}, 0.4};
  const auto more = ball.Cloud().points;
  cloud.points.insert(cloud.points.end(), more.begin(), more.end());
  const TileMesh mesh = MeshOf(cloud);
  ASSERT_EQ(mesh.components.size(), 2U);
  std::size_t first = 0;
  for (const MeshComponent& component : mesh.components) {
    const bool is_table = mesh.vertices[first].position_in_map.z() < 1;
    for (std::size_t i = 0; i < component.num_vertices; ++i) {
      EXPECT_EQ(mesh.vertices[first + i].position_in_map.z() < 1, is_table);
    }
    first += component.num_vertices;
  }
}

TEST(Mesh, TilesThatNeighboursDoNotSurroundAreRefused) {
  NIGHTMAP_EXPECT_ERROR(UsageError, MeshOf(Table(0), {{0, 0}, {0.1, 1}}), "tiles.edge_m");
}

}  // namespace nightmap::mesh_test
