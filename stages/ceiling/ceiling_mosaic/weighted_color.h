// SPDX-License-Identifier: Apache-2.0
// Mean color of a pixel over the views that show it, and how much they deviate from each other.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace nightmap {

using Rgb = std::array<double, 3>;

inline double Brightness(const Rgb& color) { return (color[0] + color[1] + color[2]) / 3; }

class WeightedColor {
 public:
  void Add(double weight, const Rgb& color) {
    weight_ += weight;
    for (std::size_t channel = 0; channel < 3; ++channel) sum_[channel] += weight * color[channel];
    square_ += weight * std::pow(Brightness(color), 2);
    ++num_views_;
  }

  int NumViews() const { return num_views_; }

  // There is a view.
  Rgb Mean() const { return {sum_[0] / weight_, sum_[1] / weight_, sum_[2] / weight_}; }

  // The brightness deviates by so much.
  double Deviation() const {
    const double variance = square_ / weight_ - std::pow(Brightness(Mean()), 2);
    return std::sqrt(std::max(0.0, variance));
  }

 private:
  double weight_ = 0, square_ = 0;
  Rgb sum_ = {0, 0, 0};
  int num_views_ = 0;
};

}  // namespace nightmap
