// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_mosaic/ceiling_heights.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/base/median.h"

namespace nightmap {
namespace {

constexpr double kCell_m = 0.1;
constexpr std::size_t kMinPoints = 3;

Eigen::Index NumCells(double length_m) {
  return std::max<Eigen::Index>(1, static_cast<Eigen::Index>(std::ceil(length_m / kCell_m)));
}

}  // namespace

CeilingHeights::CeilingHeights(const std::vector<Eigen::Vector3d>& points,
                               double radius_m,
                               const Eigen::Vector2d& low,
                               const Eigen::Vector2d& high)
    : low_(low), width_(NumCells(high.x() - low.x())), height_(NumCells(high.y() - low.y())) {
  std::vector<double> all;
  for (const Eigen::Vector3d& point : points) all.push_back(point.z());
  std::vector<std::vector<double>> near(static_cast<std::size_t>(width_ * height_));
  const auto reach = static_cast<Eigen::Index>(std::ceil(radius_m / kCell_m));
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector2d place = (point.head<2>() - low) / kCell_m;
    const auto column = static_cast<Eigen::Index>(std::floor(place.x()));
    const auto row = static_cast<Eigen::Index>(std::floor(place.y()));
    for (Eigen::Index y = std::max<Eigen::Index>(0, row - reach);
         y <= std::min(height_ - 1, row + reach);
         ++y) {
      for (Eigen::Index x = std::max<Eigen::Index>(0, column - reach);
           x <= std::min(width_ - 1, column + reach);
           ++x) {
        const double away = std::hypot(static_cast<double>(x) + 0.5 - place.x(),
                                       static_cast<double>(y) + 0.5 - place.y());
        if (away * kCell_m > radius_m) continue;
        near[static_cast<std::size_t>(y * width_ + x)].push_back(point.z());
      }
    }
  }
  heights_m_.assign(near.size(), Median(std::move(all)));
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (near[i].size() >= kMinPoints) heights_m_[i] = Median(std::move(near[i]));
  }
}

double CeilingHeights::At_m(const Eigen::Vector2d& place) const {
  const auto cell = [](double offset_m, Eigen::Index count) {
    const auto index = static_cast<Eigen::Index>(std::floor(offset_m / kCell_m));
    return std::clamp<Eigen::Index>(index, 0, count - 1);
  };
  const Eigen::Index x = cell(place.x() - low_.x(), width_);
  const Eigen::Index y = cell(place.y() - low_.y(), height_);
  return heights_m_[static_cast<std::size_t>(y * width_ + x)];
}

}  // namespace nightmap
