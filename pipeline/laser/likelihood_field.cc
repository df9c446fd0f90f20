// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/likelihood_field.h"

#include <algorithm>
#include <cmath>

namespace nightmap {
namespace {

constexpr double kReach = 3;  // in sigmas; beyond it the field is 0

}  // namespace

LikelihoodField::LikelihoodField(const LikelihoodFieldOptions& options)
    : options_(options),
      size_(static_cast<int>(std::lround(2 * options.half_extent_m / options.resolution_m))),
      cells_(static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_)),
      box_{{size_, size_}, {0, 0}} {}

void LikelihoodField::Add(const std::vector<Eigen::Vector2d>& points) {
  const double sigma_cells = options_.sigma_m / options_.resolution_m;
  const double reach_cells = kReach * sigma_cells;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d center = ToCells(point);
    if (!(center.array().abs() < 2.0 * size_).all()) continue;
    const Eigen::Array2i first = (center.array() - reach_cells).ceil().cast<int>().max(0);
    const Eigen::Array2i end = ((center.array() + reach_cells).floor().cast<int>() + 1).min(size_);
    if ((first >= end).any()) continue;
    box_.first = box_.first.cwiseMin(first.matrix());
    box_.end = box_.end.cwiseMax(end.matrix());
    for (int row = first.y(); row < end.y(); ++row) {
      for (int column = first.x(); column < end.x(); ++column) {
        const double distance_cells = (Eigen::Vector2d(column, row) - center).norm() / sigma_cells;
        float& cell = cells_[Index(column, row)];
        cell = std::max(cell, static_cast<float>(std::exp(-0.5 * distance_cells * distance_cells)));
      }
    }
  }
}

}  // namespace nightmap
