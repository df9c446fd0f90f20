// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/mesh/mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/voxel_key.h"
#include "stages/dense/mesh/components.h"
#include "stages/dense/mesh/cube_cases.h"
#include "stages/dense/mesh/implicit_surface.h"
#include "stages/dense/mesh/surface_cells.h"

namespace nightmap {
namespace {

constexpr std::size_t kNumAtOnce = 4096;

// The edge from a corner of the grid, the index of which it is, along an axis: 3 * corner + axis.
using EdgeId = std::uint64_t;
using EdgeTriangle = std::array<EdgeId, 3>;

struct Grid {
  double cell_size_m = 0;
  std::vector<std::uint64_t> cells;    // packed, ascending
  std::vector<std::uint64_t> corners;  // likewise
  std::vector<double> distances_m;     // at the corners

  Eigen::Vector3d Place(std::uint64_t corner) const {
    return UnpackVoxel(corner).cast<double>() * cell_size_m;
  }
};

std::uint64_t ShiftOf(int x, int y, int z) {
  return PackVoxel({x, y, z}) - PackVoxel(VoxelKey::Zero());
}

// Calls body(begin, end) for parts of [0, count) on several threads.
template <typename Body>
void ForParts(std::size_t count, int num_threads, const Body& body) {
  ParallelFor((count + kNumAtOnce - 1) / kNumAtOnce, num_threads, [&](std::size_t part) {
    body(part, part * kNumAtOnce, std::min(count, (part + 1) * kNumAtOnce));
  });
}

void EvaluateCorners(const ImplicitSurface& surface,
                     Grid& grid,
                     Progress& progress,
                     int num_threads) {
  grid.distances_m.resize(grid.corners.size());
  progress.Start(grid.corners.size());
  ForParts(grid.corners.size(), num_threads, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      grid.distances_m[i] = surface.At(grid.Place(grid.corners[i])).distance_m;
    }
    progress.Advance(end - begin);
  });
  progress.Finish();
}

// Finds the corners of ascending cells.
class CornerFinder {
 public:
  explicit CornerFinder(const Grid& grid) : grid_(grid) {}

  // Indices of the corners in the order of cube_cases.h; the first face is the lower one.
  std::array<std::size_t, 8> Of(std::uint64_t cell) {
    static const std::array<std::uint64_t, 4> kShifts{
        0, ShiftOf(1, 0, 0), ShiftOf(1, 1, 0), ShiftOf(0, 1, 0)};
    std::array<std::size_t, 8> corners{};
    for (std::size_t i = 0; i < 4; ++i) {
      if (!is_started_) {
        at_[i] = static_cast<std::size_t>(
            std::ranges::lower_bound(grid_.corners, cell + kShifts[i]) - grid_.corners.begin());
      }
      while (grid_.corners[at_[i]] < cell + kShifts[i]) ++at_[i];
      corners[i] = at_[i];
      corners[i + 4] = at_[i] + 1;  // the corner above follows
    }
    is_started_ = true;
    return corners;
  }

 private:
  const Grid& grid_;
  std::array<std::size_t, 4> at_{};
  bool is_started_ = false;
};

// The edge of a cell, from its end with the smaller coordinates.
EdgeId EdgeOf(int edge, const std::array<std::size_t, 8>& corners) {
  constexpr std::array<EdgeId, 12> kAxes{0, 1, 0, 1, 0, 1, 0, 1, 2, 2, 2, 2};
  const auto e = static_cast<std::size_t>(edge);
  const auto [a, b] = kCubeEdges[e];
  const std::size_t first =
      std::min(corners[static_cast<std::size_t>(a)], corners[static_cast<std::size_t>(b)]);
  return 3 * first + kAxes[e];
}

void AddTriangles(const Grid& grid,
                  const std::array<std::size_t, 8>& corners,
                  std::vector<EdgeTriangle>& triangles) {
  unsigned corners_behind = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double distance_m = grid.distances_m[corners[i]];
    if (std::isnan(distance_m)) return;
    corners_behind |= distance_m < 0 ? 1U << i : 0U;
  }
  const auto edges = EdgesOfTriangles(corners_behind);  // clockwise from the front
  for (std::size_t i = 0; i + 2 < edges.size(); i += 3) {
    triangles.push_back(
        {EdgeOf(edges[i], corners), EdgeOf(edges[i + 2], corners), EdgeOf(edges[i + 1], corners)});
  }
}

std::vector<EdgeTriangle> MarchCubes(const Grid& grid, int num_threads) {
  std::vector<std::vector<EdgeTriangle>> parts(grid.cells.size() / kNumAtOnce + 1);
  ForParts(
      grid.cells.size(), num_threads, [&](std::size_t part, std::size_t begin, std::size_t end) {
        CornerFinder finder(grid);
        for (std::size_t i = begin; i < end; ++i) {
          AddTriangles(grid, finder.Of(grid.cells[i]), parts[part]);
        }
      });
  std::vector<EdgeTriangle> triangles;
  for (const auto& part : parts) triangles.insert(triangles.end(), part.begin(), part.end());
  return triangles;
}

std::vector<EdgeId> EdgesIn(const std::vector<EdgeTriangle>& triangles) {
  std::vector<EdgeId> edges;
  edges.reserve(3 * triangles.size());
  for (const EdgeTriangle& triangle : triangles) {
    edges.insert(edges.end(), triangle.begin(), triangle.end());
  }
  std::ranges::sort(edges);
  const auto repeated = std::ranges::unique(edges);
  edges.erase(repeated.begin(), repeated.end());
  return edges;
}

// The place on an edge where the distance is zero. Its normal is zero where no point is near.
MeshVertex VertexOn(const Grid& grid,
                    const ImplicitSurface& surface,
                    double max_gap_m,
                    EdgeId edge) {
  const std::size_t corner = edge / 3;
  const auto axis = static_cast<Eigen::Index>(edge % 3);
  VoxelKey step = VoxelKey::Zero();
  step[axis] = 1;
  const std::uint64_t other_key = grid.corners[corner] + ShiftOf(step.x(), step.y(), step.z());
  const auto other = static_cast<std::size_t>(std::ranges::lower_bound(grid.corners, other_key) -
                                              grid.corners.begin());
  const double here_m = grid.distances_m[corner], there_m = grid.distances_m[other];
  Eigen::Vector3d place = grid.Place(grid.corners[corner]);
  place[axis] += grid.cell_size_m * here_m / (here_m - there_m);
  const SurfaceSample sample = surface.At(place);
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
bool IsOnSeam(const Grid& grid, const Rectangle& tile, EdgeId edge) {
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
// The distance is also zero between the two sides of a thin wall, or beside it: there the triangles
// face the other way.
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
  const double cells = 2 * options.cell_voxels + options.max_gap_voxels;
  return (cells + options.radius_voxels) * voxel_size_m;
}

TileMesh RunMesh(const MeshOptions& options,
                 const MeshCloud& cloud,
                 const Rectangle& tile,
                 Progress& progress,
                 int num_threads) {
  CheckTileSize(tile, MeshReach_m(options, cloud.voxel_size_m));
  const double max_gap_m = options.max_gap_voxels * cloud.voxel_size_m;
  const ImplicitSurface surface(cloud.points, options.radius_voxels * cloud.voxel_size_m);
  Grid grid{options.cell_voxels * cloud.voxel_size_m, {}, {}, {}};
  grid.cells = CellsNear(cloud.points, tile, grid.cell_size_m, max_gap_m);
  grid.corners = CornersOf(grid.cells);
  EvaluateCorners(surface, grid, progress, num_threads);
  const std::vector<EdgeTriangle> found = MarchCubes(grid, num_threads);
  const std::vector<EdgeId> edges = EdgesIn(found);
  std::vector<MeshVertex> vertices(edges.size());
  ForParts(edges.size(), num_threads, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      vertices[i] = VertexOn(grid, surface, max_gap_m, edges[i]);
    }
  });
  std::vector<bool> is_on_seam;
  for (const EdgeId edge : edges) is_on_seam.push_back(IsOnSeam(grid, tile, edge));
  std::vector<Triangle> triangles;
  for (const EdgeTriangle& some : found) {
    Triangle triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      triangle[i] =
          static_cast<std::uint32_t>(std::ranges::lower_bound(edges, some[i]) - edges.begin());
    }
    if (IsSurface(vertices, triangle)) triangles.push_back(triangle);
  }
  return GroupComponents(vertices, is_on_seam, triangles);
}

}  // namespace nightmap
