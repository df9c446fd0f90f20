// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/mesh/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/voxel_key.h"
#include "stages/dense/mesh/components.h"
#include "stages/dense/mesh/implicit_surface.h"
#include "stages/dense/mesh/march_cubes.h"
#include "stages/dense/mesh/surface_cells.h"

namespace nightmap {
namespace {

Eigen::Vector3d PlaceOf(const SampledGrid& grid, std::size_t corner) {
  return UnpackVoxel(grid.corners[corner]).cast<double>() * grid.cell_size_m;
}

std::vector<EdgeId> EdgesIn(const std::vector<EdgeTriangle>& triangles) {
  std::vector<EdgeId> edges;
  edges.reserve(3 * triangles.size());
  for (const EdgeTriangle& triangle : triangles) {
    edges.insert(edges.end(), triangle.begin(), triangle.end());
  }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// The diagonal of a cell.
double Diagonal_m(const MeshOptions& options, double voxel_size_m) {
  return std::sqrt(3.0) * options.cell_voxels * voxel_size_m;
}

// The distance at a corner of the grid. Where no point is within the radius, points as far away as
// the other end of the cell tell on which side it is.
double DistanceAt(const ImplicitSurface& surface,
                  const Eigen::Vector3d& corner,
                  double radius_m,
                  double diagonal_m) {
  const double distance_m = surface.At(corner, radius_m).distance_m;
  if (!std::isnan(distance_m)) return distance_m;
  return surface.At(corner, radius_m + diagonal_m).distance_m;
}

// The place on an edge where the distance is zero. Its normal is zero where no point is near.
MeshVertex VertexOn(const SampledGrid& grid,
                    const ImplicitSurface& surface,
                    double radius_m,
                    double max_gap_m,
                    EdgeId edge) {
  const std::size_t corner = edge / 3;
  const auto axis = static_cast<Eigen::Index>(edge % 3);
  VoxelKey step = VoxelKey::Zero();
  step[axis] = 1;
  const std::uint64_t other = grid.corners[corner] + ShiftOf(step.x(), step.y(), step.z());
  const auto at = std::ranges::lower_bound(grid.corners, other) - grid.corners.begin();
  const double here_m = grid.distances_m[corner];
  const double there_m = grid.distances_m[static_cast<std::size_t>(at)];
  Eigen::Vector3d place = PlaceOf(grid, corner);
  place[axis] += grid.cell_size_m * here_m / (here_m - there_m);
  const SurfaceSample sample = surface.At(place, radius_m);
  MeshVertex vertex;
  vertex.position_in_map = place.cast<float>();
  if (!(sample.nearest_m <= max_gap_m)) return vertex;
  vertex.normal_in_map = sample.normal.normalized().cast<float>();
  for (int channel = 0; channel < 3; ++channel) {
    vertex.rgb[static_cast<std::size_t>(channel)] =
        static_cast<std::uint8_t>(std::floor(sample.rgb[channel] + 0.5));
  }
  return vertex;
}

// Whether a cell at the edge belongs to another tile.
bool IsOnSeam(const SampledGrid& grid, const Rectangle& tile, EdgeId edge) {
  const std::uint64_t corner = grid.corners[edge / 3];
  for (const int x : {0, -1}) {
    for (const int y : {0, -1}) {
      if ((edge % 3 == 0 && x != 0) || (edge % 3 == 1 && y != 0)) continue;
      if (!IsCellOf(tile, corner + ShiftOf(x, y, 0), grid.cell_size_m)) return true;
    }
  }
  return false;
}

// Whether points are near all its vertices, and its front is the side that these were seen from.
// Between a panel and the wall behind it the distance is zero, too: there triangles face the other
// way.
bool IsSurface(const std::vector<MeshVertex>& vertices, const Triangle& triangle) {
  const MeshVertex &a = vertices[triangle[0]], &b = vertices[triangle[1]],
                   &c = vertices[triangle[2]];
  for (const MeshVertex* vertex : {&a, &b, &c}) {
    if (vertex->normal_in_map.isZero(0)) return false;
  }
  const Eigen::Vector3d across = (b.position_in_map - a.position_in_map)
                                     .cast<double>()
                                     .cross((c.position_in_map - a.position_in_map).cast<double>());
  const Eigen::Vector3f seen_from = a.normal_in_map + b.normal_in_map + c.normal_in_map;
  return across.dot(seen_from.cast<double>()) > 0;
}

std::vector<Triangle> SurfaceTriangles(const std::vector<EdgeTriangle>& found,
                                       const std::vector<EdgeId>& edges,
                                       const std::vector<MeshVertex>& vertices) {
  std::vector<Triangle> triangles;
  for (const EdgeTriangle& some : found) {
    Triangle triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      triangle[i] =
          static_cast<std::uint32_t>(std::ranges::lower_bound(edges, some[i]) - edges.begin());
    }
    if (IsSurface(vertices, triangle)) triangles.push_back(triangle);
  }
  return triangles;
}

void CheckTileSize(const Rectangle& tile, double reach_m) {
  const double edge_m = (tile.max_m - tile.min_m).minCoeff();
  if (edge_m >= reach_m) return;
  throw UsageError(
      "tiles of {} m are smaller than the {} m from which points change the mesh; raise "
      "tiles.edge_m, or lower mesh.radius_voxels or mesh.cell_voxels",
      edge_m,
      reach_m);
}

}  // namespace

double MeshReach_m(const MeshOptions& options, double voxel_size_m) {
  const double cells = 3 * options.cell_voxels + options.max_gap_voxels;
  return (cells + options.radius_voxels) * voxel_size_m;
}

TileMesh RunMesh(const MeshOptions& options,
                 const MeshCloud& cloud,
                 const Rectangle& tile,
                 int num_threads) {
  CheckTileSize(tile, MeshReach_m(options, cloud.voxel_size_m));
  const double max_gap_m = options.max_gap_voxels * cloud.voxel_size_m;
  const double radius_m = options.radius_voxels * cloud.voxel_size_m;
  const double diagonal_m = Diagonal_m(options, cloud.voxel_size_m);
  const ImplicitSurface surface(cloud.points, radius_m);
  SampledGrid grid{options.cell_voxels * cloud.voxel_size_m, {}, {}, {}};
  grid.cells = CellsNear(cloud.points, tile, grid.cell_size_m, max_gap_m);
  grid.corners = CornersOf(grid.cells);
  grid.distances_m.resize(grid.corners.size());
  ParallelForShort(grid.corners.size(), num_threads, [&](std::size_t i) {
    grid.distances_m[i] = DistanceAt(surface, PlaceOf(grid, i), radius_m, diagonal_m);
  });
  const std::vector<EdgeTriangle> found = MarchCubes(grid, num_threads);
  const std::vector<EdgeId> edges = EdgesIn(found);
  std::vector<MeshVertex> vertices(edges.size());
  ParallelForShort(edges.size(), num_threads, [&](std::size_t i) {
    vertices[i] = VertexOn(grid, surface, radius_m, max_gap_m, edges[i]);
  });
  std::vector<bool> is_on_seam;
  for (const EdgeId edge : edges) is_on_seam.push_back(IsOnSeam(grid, tile, edge));
  return GroupComponents(vertices, is_on_seam, SurfaceTriangles(found, edges, vertices));
}

}  // namespace nightmap
