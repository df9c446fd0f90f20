// SPDX-License-Identifier: Apache-2.0
// How a frame agrees with the one before it.
#pragma once

#include "pipeline/io/image_io.h"

namespace nightmap {

struct PairMeasures {
  bool has_previous = false;
  bool same_color = false;   // the same pixels
  bool same_depth = false;   // the same pixels; false where none has depth
  double tracked_share = 0;  // of the corners of the previous frame
  double flow_px = 0;        // median motion of these in the picture, in pixels of the reduced one
  double gain = 1;           // brightness of this frame over that of the previous one
};

// The brightness ratio is the median over the cells of a coarse grid: a change of the picture moves
// single cells, a change of exposure all of them. 1 where too few cells are neither black nor
// white. Its `spread` is their median absolute deviation.
struct Gain {
  double ratio = 1;
  double spread = 0;
};
Gain GainBetween(const GrayImage& previous, const GrayImage& current);

// Both reduced to about 320 pixels of width, of one size. Corners are followed there and back; what
// comes back within a pixel counts. The gain is 1 where its spread hides it. Deterministic.
PairMeasures MeasurePair(const GrayImage& previous, const GrayImage& current);

}  // namespace nightmap
