// SPDX-License-Identifier: Apache-2.0
// Smooths a path over the cost map: moves it to the cheapest places around it and straightens it.
// Points are in cells; the centre of cell (x, y) is at (x + 0.5, y + 0.5). Paths are free and stay
// free; their costs never rise, and their first and last points stay. Deterministic.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/plan/plan/cost_map.h"

namespace nightmap {

// Replaces stretches of a path by straight segments wherever these are free and cost no more.
std::vector<Eigen::Vector2d> Shorten(const CostMap& map, const std::vector<Eigen::Vector2d>& path);

// The path's points, with points added so that no neighbours are more than `gap_cells` apart.
std::vector<Eigen::Vector2d> Resample(const std::vector<Eigen::Vector2d>& path,
                                      double gap_cells = 1);

// An elastic band (Quinlan and Khatib, Elastic bands: connecting path planning and control, 1993)
// that minimizes the exact cost of its straight lines. Moves points of the path sideways, together
// with the points around them in proportion, over shrinking stretches and by shrinking steps.
std::vector<Eigen::Vector2d> Relax(const CostMap& map, const std::vector<Eigen::Vector2d>& path);

// The whole smoother: shortens and relaxes a path, then straightens bends that save no cost. Points
// are at most one cell apart.
std::vector<Eigen::Vector2d> Tighten(const CostMap& map, const std::vector<Eigen::Vector2d>& path);

}  // namespace nightmap
