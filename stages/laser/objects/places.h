// SPDX-License-Identifier: Apache-2.0
// Places of a grid whose walls fix where a scan of them is.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/io/grid_io.h"

namespace nightmap {

// A disc of the grid: other than a square it is the same at any heading of the map. Lengths are in
// cells, and so are points: the centre of cell (x, y) is (x, y).
struct Place {
  Eigen::Vector2i center = Eigen::Vector2i::Zero();
  std::vector<Eigen::Vector2i> cells;  // the occupied ones
  // About the length of wall that hinders the place from sliding over another in the direction in
  // which it slides best: 0 on a straight wall.
  double wall = 0;
  double heading_rad = 0;  // of the walls, from the rows of the grid on, -pi/4 .. pi/4
  // How much of the walls runs along that heading or across it: 0 if all headings are as frequent.
  double straightness = 0;
  double seen_share = 0;       // of the occupied cells, those beside free ones
  double distinctiveness = 0;  // of the map's places; not by FindPlaces
};

// The places that mean shift (Comaniciu, Meer, Mean shift, PAMI 2002) leads to from every occupied
// cell: each is about the mean of its occupied cells. Keeps those with at least `min_wall` in order
// of it. Walls are found by the structure tensor (Shi, Tomasi, Good features to track, CVPR 1994).
// Deterministic at any number of threads.
std::vector<Place> FindPlaces(const OccupancyGrid& grid,
                              double radius,
                              double min_wall,
                              int num_threads);

}  // namespace nightmap
