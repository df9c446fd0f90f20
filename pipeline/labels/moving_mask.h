// SPDX-License-Identifier: Apache-2.0
// Where a labelled picture shows what can move by itself, judged by class alone.
#pragma once

#include "pipeline/io/labels_io.h"

namespace nightmap {

struct MovingMaskOptions {
  double min_confidence = 0.3;  // 0 .. 1
  int margin_px = 6;
};

// 255 where the label is a class that moves by itself, with enough confidence, and up to margin_px
// around; elsewhere 0. The mask has the picture's size. Deterministic.
GrayImage MovingMask(const Segmentation& segmentation,
                     const LabelClasses& classes,
                     const MovingMaskOptions& options);

}  // namespace nightmap
