// SPDX-License-Identifier: Apache-2.0
// Pictures of a CeilingWorld by a pinhole camera.
//
// Pixel (0, 0) is the centre of the top left pixel. The camera's axes are x to the right of the
// picture, y down, z into the scene. A camera that looks straight up from a robot has the robot's
// axes: the picture's right is forward, its bottom is the robot's left.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/image_io.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_world.h"

namespace nightmap {

// Linear brightness of three channels at gain 1, not clipped: the mean over the poses
// building_from_camera of the times within the exposure; 1, 2 or 4 of them. Each pixel is the mean
// over about its area: faces are filtered by pyramids, and pixels at the border between faces have
// 16 samples. The lens distorts nothing. Throws UsageError for another number of poses.
Image<float> RenderCeiling(const CeilingWorld& world,
                           const Camera& camera,
                           const std::vector<Rigid3>& building_from_camera);

// Mean brightness of a picture as an exposure meter has it, of few rays. A lamp counts as at most
// 900.
double MeterCeiling(const CeilingWorld& world, const Camera& camera, const Rigid3& pose);

struct SensorNoise {
  double gain = 1;
  double vignetting = 0;    // share of the light that the corners lack
  double noise_levels = 0;  // sigma of each channel of a pixel
};

// The sensor's answer to a radiance: gain, vignetting with the squared distance from the middle,
// noise, and 8 bits, which clip. `seed` alone decides the noise.
ColorImage ExposeCeiling(const Image<float>& radiance,
                         const SensorNoise& noise,
                         std::uint64_t seed);

}  // namespace nightmap
