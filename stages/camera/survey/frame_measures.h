// SPDX-License-Identifier: Apache-2.0
// Qualities of a frame: exposure, sharpness, texture, depth.
#pragma once

#include "pipeline/io/frames_io.h"
#include "stages/camera/survey/planar_share.h"

namespace nightmap {

struct FrameMeasures {
  double brightness = 0;      // mean gray level, 0 .. 255
  double dark_share = 0;      // of pixels below 8
  double bright_share = 0;    // of pixels above 247
  double blur_px = 0;         // sigma of the blur of the strongest edges, see BlurOf
  double textured_share = 0;  // of the picture's cells that have a corner to follow
  double measured_share = 0;  // of depth pixels; 0 of a frame without depth, like all below
  double depth_p10_m = 0;     // quantiles of the measured depth, 0 if none is measured
  double depth_median_m = 0;
  double depth_p90_m = 0;
  PlanarShares planar;  // shares of the depth on its largest plane
};

// Sigma in pixels of the Gaussian that would blur ideal steps as much as the picture's strongest
// edges are: the second largest of four directions, since motion blurs all but the edges along it.
// 0 of a picture without edges. Source: ratio of the gradients of a picture blurred once more by
// two known sigmas, Zhuo and Sim, Defocus map estimation from a single image, Pattern Recognition
// 2011.
double BlurOf(const GrayImage& gray);

// `small`: gray reduced to about 320 pixels of width.
FrameMeasures MeasureFrame(const GrayImage& gray, const GrayImage& small, const DepthImage& depth);

}  // namespace nightmap
