// SPDX-License-Identifier: Apache-2.0
// A keyframe reduced to what the search for ghosts needs, so that all of a site fit in memory.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/dense/tiles_io.h"

namespace nightmap {

// Points of a thing that may move, in the map.
using RegionPoints = std::vector<Eigen::Vector3d>;

struct KeyframeView {
  const Keyframe* keyframe = nullptr;
  const RgbdCamera* camera = nullptr;
  Rigid3 camera_from_map;
  int block_px = 1;                  // edge of a block of pixels
  Image<std::uint16_t> nearest_mm;   // of each block; 0: most of it is not measured
  Image<std::int32_t> region;        // of each block, from 1; 0: none
  std::vector<RegionPoints> points;  // of each region, less 1
};

// Blocks are about an 80th of the picture wide. `may_move` may be empty. Throws DataError when its
// size is not that of `depth`.
KeyframeView MakeKeyframeView(const Keyframe& keyframe,
                              const RgbdCamera& camera,
                              const DepthImage& depth,
                              const GrayImage& may_move);

// False only when the view sees nothing of a ball around a point of the map.
bool MaySee(const KeyframeView& view, const Eigen::Vector3d& centre_in_map, double radius_m);

// Whether the view sees through a share of the points that it sees. Says no where it sees less than
// a third of them.
bool SeesThrough(const KeyframeView& view,
                 const RegionPoints& points,
                 double min_share,
                 double min_difference_m,
                 double num_sigmas);

}  // namespace nightmap
