// SPDX-License-Identifier: Apache-2.0
// mesh: the surface on which the points of a cloud lie, as triangles.
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/dense/mesh_io.h"
#include "pipeline/dense/ply_io.h"
#include "pipeline/geometry/rectangle.h"

namespace nightmap {

struct MeshOptions {
  OPTION(double, cell_voxels, 2.0, {0.5, 20.0},
         "edge of a cell of the surface, in voxels of the cloud; triangles are about as large");
  OPTION(double, radius_voxels, 3.0, {1.0, 40.0},
         "radius of the points that give the surface at a place, in voxels of the cloud: larger is "
         "smoother, and rounds edges");
  OPTION(double, max_gap_voxels, 1.5, {0.5, 20.0},
         "no surface farther than this from the nearest point, in voxels of the cloud");
  REGISTER_OPTIONS();
};

// Cloud of a tile and around it, in metres of the map frame.
struct MeshCloud {
  std::vector<CloudPoint> points;
  double voxel_size_m = 0;  // with which the points were made
};

// The distance up to which points around a tile change its mesh.
double MeshReach_m(const MeshOptions& options, double voxel_size_m);

// The zero of the signed distance f(x), the mean of n_i . (x - p_i) over the points p_i with
// normals n_i around x, weighted by their distance from x (implicit moving least squares: Kolluri,
// Provably Good Moving Least Squares, ACM Transactions on Algorithms 4, 2008; Hoppe et al., Surface
// Reconstruction from Unorganized Points, SIGGRAPH 1992). f is evaluated at corners of a grid that
// has a corner at the origin of the map, and marching cubes give the triangles (Lorensen and Cline,
// SIGGRAPH 1987).
//
// Returns the triangles of the cells whose lower corner lies in `tile`; components come in order of
// their first vertex. No point, no triangles. Given all points within MeshReach_m of them, tiles
// that together cover the map have the triangles of one that does, and vertices of the same cell
// edge are equal to the last bit. Same result at any number of threads and in any order of the
// points. Throws UsageError when the neighbours of a tile do not hold all these points.
TileMesh RunMesh(const MeshOptions& options,
                 const MeshCloud& cloud,
                 const Rectangle& tile,
                 int num_threads);

}  // namespace nightmap
