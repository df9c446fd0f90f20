// SPDX-License-Identifier: Apache-2.0
// Completes the box of a thing where nobody saw its end: furniture is seen from one side.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "stages/labels/things/labelled_space.h"
#include "stages/labels/things/upright_box.h"

namespace nightmap {

struct CompletionOptions {
  std::uint8_t label = 0;                  // of the thing
  std::array<bool, 256> is_thing_class{};  // what is occupied of another class, or of none, is
                                           // wall, floor and the like
  double max_hidden_m = 0;                 // by which a side may move
  std::optional<int> top_layer;            // of a thing that is a top on legs
  bool is_whole = false;                   // other voxels of the class are of another thing
};

// Moves the lower side down to the ground around the thing when that is within max_hidden_m and the
// space below the thing's lowest voxels was not seen free. `points_in_map` are the voxels' centres.
//
// Then moves the four sides outwards, layer of voxels by layer, while a layer is hidden: at most a
// tenth of it was seen free, for a box that reached so far would hide all of it, and at most a
// tenth is occupied by something else. A wall in the plane of a layer, beside or above the thing,
// ends the hidden space too, up to 0.5 m away. Where a wall or another thing ends it, the side
// moves up to that: furniture stands against walls. Where seen space or max_hidden_m ends it, the
// thing may end anywhere before, and the side moves half as far. A side that faces free space
// stays.
//
// A top on legs has free space below it, and things stand on it and before it. So it is lowered to
// the ground whatever was seen there, and of its sides only the layer of the top is asked, in which
// other things hide it rather than end it.
void CompleteBox(const CompletionOptions& options,
                 const LabelledSpace& space,
                 const std::vector<Eigen::Vector3d>& points_in_map,
                 UprightBox* box);

}  // namespace nightmap
