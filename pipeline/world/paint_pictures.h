// SPDX-License-Identifier: Apache-2.0
// Painters of posters, panels and bookshelves, and helpers that all painters share.
#pragma once

#include <Eigen/Core>

#include "pipeline/base/random.h"
#include "pipeline/world/canvas.h"

namespace nightmap {

float Uniform(Random& random, double low, double high);
Eigen::Vector2f RandomPoint(Random& random);

// Draws blobs with log-uniform radii, so that there are features at every distance of the camera.
void Scatter(Canvas& canvas,
             int count,
             double min_radius,
             double max_radius,
             float darkest,
             float brightest,
             float opacity,
             Random& random);

Canvas Poster(int size_px, Random& random);
Canvas Panel(int size_px, Random& random);
Canvas Books(int size_px, Random& random);

}  // namespace nightmap
