// SPDX-License-Identifier: Apache-2.0
// The triangles of a cube of which some corners lie behind a surface.
#pragma once

#include <array>
#include <span>

namespace nightmap {

// Corners 0 to 3 go around one face, 4 to 7 are beside them on the opposite face. Edges 0 to 3 go
// around the first face, from corner 0 to 1, 1 to 2 and so on, 4 to 7 around the other, and 8 to 11
// between the faces.
constexpr std::array<std::array<int, 2>, 12> kCubeEdges{{{0, 1},
                                                         {1, 2},
                                                         {2, 3},
                                                         {3, 0},
                                                         {4, 5},
                                                         {5, 6},
                                                         {6, 7},
                                                         {7, 4},
                                                         {0, 4},
                                                         {1, 5},
                                                         {2, 6},
                                                         {3, 7}}};

// Edges that the corners of the triangles lie on, three per triangle, by PCL's table of marching
// cubes. Bit i of `corners_behind`: corner i.
std::span<const int> EdgesOfTriangles(unsigned corners_behind);

}  // namespace nightmap
