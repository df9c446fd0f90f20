// SPDX-License-Identifier: Apache-2.0
// Renders pictures of the synthetic building: anti-aliased color, depth as a structured-light
// sensor would measure it, exact depth, and the class of every pixel.
#pragma once

#include <cstdint>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/image_io.h"
#include "pipeline/world/synthetic_world.h"

namespace nightmap {

struct RenderedFrame {
  ColorImage color;
  DepthImage depth;        // metres along z with noise, quantization and holes; 0 = no measurement
  DepthImage exact_depth;  // metres along z at the pixel's centre; 0 where nothing is hit
  LabelImage labels;       // SurfaceLabel at the pixel's centre
  Image<std::int32_t> surface_idx;  // surface of the scene at the pixel's centre; -1: none
};

// `camera` must have no distortion (else UsageError). Noise depends on `noise_seed` alone, so give
// each frame its own seed.
RenderedFrame Render(const SyntheticWorld& world,
                     const Camera& camera,
                     const Rigid3& building_from_camera,
                     const DepthSensorOptions& sensor,
                     double color_noise_levels,
                     std::uint64_t noise_seed);

// Depth that a sensor measures, given the exact depth, the surface and the incidence.
DepthImage MeasureDepth(const DepthImage& exact_depth,
                        const Image<std::int32_t>& surface_idx,
                        const Image<float>& incidence_cosine,
                        const Camera& camera,
                        const DepthSensorOptions& sensor,
                        std::uint64_t noise_seed);

}  // namespace nightmap
