// SPDX-License-Identifier: Apache-2.0
// How flat depth shows flat surfaces, as z and as the distance along the ray.
#pragma once

#include "pipeline/geometry/camera.h"
#include "pipeline/io/image_io.h"

namespace nightmap {

// Shares of the sampled depth that lie on the plane with most of it. The inverse of z on a plane is
// linear in the pixel, whatever the focal length; the distance along the ray is not.
struct PlanarShares {
  double as_declared = 0;  // both 0 where hardly any depth is measured
  double otherwise = 0;    // if z were distances along the ray, or distances were z
};

// `depth` is z of the color camera's pixels; `is_along_ray`: it was made of distances along the
// ray. Planes by RANSAC (Fischler and Bolles, 1981) on the same triples of pixels for both, then
// least squares. Deterministic: `seed` draws the triples.
PlanarShares MeasurePlanarShares(const DepthImage& depth,
                                 const Camera& camera,
                                 bool is_along_ray,
                                 std::uint64_t seed);

}  // namespace nightmap
