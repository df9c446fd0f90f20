// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/mesh/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::mesh_test {

constexpr double kVoxel_m = 0.02;
constexpr double kNoise_m = 0.003;

CloudPoint PointAt(const Eigen::Vector3d& position, const Eigen::Vector3d& normal, Random& random) {
  CloudPoint point;
  point.position_in_map = (position + kNoise_m * random.Gaussian() * normal).cast<float>();
  point.normal_in_map = normal.cast<float>();
  point.rgb = {200, 100, 50};
  return point;
}

// A sphere around (0.3, -0.2, 1), seen from outside; a point per voxel or so (Fibonacci lattice).
struct Ball {
  Eigen::Vector3d centre{0.3, -0.2, 1};
  double radius_m = 0.7;

  MeshCloud Cloud() const {
    MeshCloud cloud{{}, kVoxel_m};
    Random random(1);
    const int num_points = static_cast<int>(16 * radius_m * radius_m / (kVoxel_m * kVoxel_m));
    for (int i = 0; i < num_points; ++i) {
      const double z = 1 - (2 * i + 1.0) / num_points;
      const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
      const double r = std::sqrt(1 - z * z);
      const Eigen::Vector3d normal(r * std::cos(angle), r * std::sin(angle), z);
      cloud.points.push_back(PointAt(centre + radius_m * normal, normal, random));
    }
    return cloud;
  }
};

// The plane z = 0.5 of edge 2 m, seen from above, without the points in a disc around the middle.
MeshCloud Table(double hole_radius_m) {
  MeshCloud cloud{{}, kVoxel_m};
  Random random(2);
  for (double x = -1; x < 1; x += kVoxel_m) {
    for (double y = -1; y < 1; y += kVoxel_m) {
      if (std::hypot(x, y) < hole_radius_m) continue;
      cloud.points.push_back(PointAt({x, y, 0.5}, Eigen::Vector3d::UnitZ(), random));
    }
  }
  return cloud;
}

TileMesh MeshOf(const MeshCloud& cloud, const Rectangle& tile = {}, int num_threads = 2) {
  return RunMesh(MeshOptions{}, cloud, tile, num_threads);
}

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
    std::ranges::rotate(corners, std::ranges::min_element(corners));
    triangles.insert(corners);
  }
  return triangles;
}

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

TEST(Mesh, ASphereIsClosedWithinMillimetresAndSeenFromOutside) {
  const Ball ball;
  const TileMesh mesh = MeshOf(ball.Cloud());
  ASSERT_EQ(mesh.components.size(), 1U);
  const double area_m2 = 4 * std::numbers::pi * ball.radius_m * ball.radius_m;
  EXPECT_NEAR(mesh.components[0].area_m2, area_m2, 0.01 * area_m2);
  for (const MeshVertex& vertex : mesh.vertices) {
    const Eigen::Vector3d out = vertex.position_in_map.cast<double>() - ball.centre;
    EXPECT_NEAR(out.norm(), ball.radius_m, 0.003);
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
  double area_m2 = 0;
  for (const MeshComponent& component : mesh.components) area_m2 += component.area_m2;
  EXPECT_NEAR(area_m2, 8.0, 0.4);
}

std::multiset<Corners> TrianglesOfTiles(const MeshCloud& cloud, double border_m) {
  std::multiset<Corners> triangles;
  const double reach_m = MeshReach_m(MeshOptions(), kVoxel_m);
  for (const Rectangle& tile :
       {Rectangle{{-3, -3}, {border_m, 3}}, Rectangle{{border_m, -3}, {3, 3}}}) {
    MeshCloud near{{}, kVoxel_m};
    std::ranges::copy_if(
        cloud.points, std::back_inserter(near.points), [&](const CloudPoint& point) {
          return tile.Grown(reach_m).Contains(point.position_in_map.head<2>().cast<double>());
        });
    triangles.merge(TrianglesOf(MeshOf(near, tile)));
  }
  return triangles;
}

TEST(Mesh, TwoTilesHaveTheTrianglesOfOne) {
  const MeshCloud cloud = Ball().Cloud();
  const auto whole = TrianglesOf(MeshOf(cloud));
  EXPECT_EQ(TrianglesOfTiles(cloud, 0.24), whole);  // on a border of cells
  EXPECT_EQ(TrianglesOfTiles(cloud, 0.333), whole);
}

TEST(Mesh, VerticesOfTwoTilesAreOnTheSeam) {
  const MeshCloud cloud = Ball().Cloud();
  std::array<std::set<Corner>, 2> all, on_seam;
  for (const std::size_t side : {0U, 1U}) {
    const Rectangle tile =
        side == 0 ? Rectangle{{-3, -3}, {0.333, 3}} : Rectangle{{0.333, -3}, {3, 3}};
    const TileMesh mesh = MeshOf(cloud, tile);
    std::size_t first = 0;
    for (const MeshComponent& component : mesh.components) {
      for (std::size_t i = 0; i < component.num_vertices; ++i) {
        const Eigen::Vector3f& p = mesh.vertices[first + i].position_in_map;
        all[side].insert({p.x(), p.y(), p.z()});
        if (i < component.num_seam_vertices) on_seam[side].insert({p.x(), p.y(), p.z()});
      }
      first += component.num_vertices;
    }
  }
  std::set<Corner> shared;
  std::ranges::set_intersection(all[0], all[1], std::inserter(shared, shared.end()));
  EXPECT_GT(shared.size(), 50U);
  EXPECT_EQ(on_seam[0], shared);
  EXPECT_EQ(on_seam[1], shared);
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
