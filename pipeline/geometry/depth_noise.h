// SPDX-License-Identifier: Apache-2.0
// How uncertain a measured depth is.
#pragma once

namespace nightmap {

// Standard deviation of structured-light or time-of-flight depth; it grows with z squared
// (Khoshelham and Elberink, Sensors 2012).
struct DepthNoise {
  static constexpr double kMinConstant_m = 1e-5;  // sigma 0 would give an infinite weight
  double constant_m = 0.002;
  double quadratic_per_m = 0.0025;  // sigma = constant + quadratic * z^2
  double Sigma_m(double depth_m) const { return constant_m + quadratic_per_m * depth_m * depth_m; }
};

}  // namespace nightmap
