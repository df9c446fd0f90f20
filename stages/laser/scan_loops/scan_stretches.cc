// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/scan_stretches.h"

#include <algorithm>
#include <tuple>

namespace nightmap {
namespace {

constexpr double kQuerySpacing_m = 1;  // path from one place that is looked for to the next

// The keyscans within half a length of path from the one at `middle`.
ScanStretch Around(const std::vector<Keyscan>& keyscans, std::size_t middle, double length_m) {
  const auto at = [&](double path_m) {
    return static_cast<std::size_t>(
        std::ranges::lower_bound(keyscans, path_m, {}, &Keyscan::path_m) - keyscans.begin());
  };
  const double path_m = keyscans[middle].path_m;
  const std::size_t first = std::min(middle, at(path_m - length_m / 2));
  return {first, middle, std::max(middle + 1, at(path_m + length_m / 2))};
}

// A stretch about the first keyscan at or after each multiple of the spacing.
std::vector<ScanStretch> Cut(const std::vector<Keyscan>& keyscans,
                             double spacing_m,
                             double length_m) {
  std::vector<ScanStretch> stretches;
  double next_m = 0;
  for (std::size_t i = 0; i < keyscans.size(); ++i) {
    if (keyscans[i].path_m < next_m) continue;
    stretches.push_back(Around(keyscans, i, length_m));
    next_m = keyscans[i].path_m + spacing_m;
  }
  return stretches;
}

// Index of a submap, with its distance from the query less three sigmas of the drift.
struct Nearby {
  double distance_m = 0;
  std::size_t submap = 0;
  Drift drift;
};

}  // namespace

std::vector<ScanStretch> CutSubmaps(const ScanLoopsOptions& options,
                                    const std::vector<Keyscan>& keyscans) {
  return Cut(keyscans, options.submap_length_m / 2, options.submap_length_m);
}

std::vector<ScanStretch> CutQueries(const ScanLoopsOptions& options,
                                    const std::vector<Keyscan>& keyscans) {
  return Cut(keyscans, kQuerySpacing_m, options.query_length_m);
}

StretchPoints PointsOf(const std::vector<Keyscan>& keyscans, const ScanStretch& stretch) {
  const Rigid2 middle_from_start = keyscans[stretch.middle].start_from_robot.Inverse();
  StretchPoints result;
  for (std::size_t i = stretch.first; i < stretch.end; ++i) {
    const Rigid2 middle_from_robot = middle_from_start * keyscans[i].start_from_robot;
    for (const Eigen::Vector2d& point : keyscans[i].points_in_robot) {
      result.points.push_back(middle_from_robot * point);
    }
    const Eigen::Rotation2Dd turn(middle_from_robot.heading_rad);
    for (const Eigen::Vector2d& normal : keyscans[i].normals_in_robot) {
      result.normals.push_back(turn * normal);
    }
  }
  return result;
}

std::vector<LoopPair> PairsToTry(const ScanLoopsOptions& options,
                                 const std::vector<Keyscan>& keyscans,
                                 const DriftSums& drifts,
                                 const std::vector<ScanStretch>& submaps,
                                 const std::vector<ScanStretch>& queries) {
  std::vector<LoopPair> pairs;
  for (std::size_t query = 0; query < queries.size(); ++query) {
    const Keyscan& sought = keyscans[queries[query].middle];
    std::vector<Nearby> nearby;
    for (std::size_t submap = 0; submap < submaps.size(); ++submap) {
      if (keyscans[submaps[submap].end - 1].path_m + options.min_path_m > sought.path_m) break;
      const std::size_t middle = submaps[submap].middle;
      const Drift drift = drifts.Between(middle, queries[query].middle);
      if (drift.IsUnknown()) {
        if (query % kUnknownSpacing == 0 && submap % 2 == 0)
          pairs.push_back({submap, query, drift});
        continue;
      }
      const Eigen::Vector2d apart =
          keyscans[middle].start_from_robot.translation - sought.start_from_robot.translation;
      const double distance_m = apart.norm() - 3 * drift.Sigma_m();
      if (distance_m <= options.max_distance_m) nearby.push_back({apart.norm(), submap, drift});
    }
    std::ranges::sort(
        nearby, {}, [](const Nearby& near) { return std::tuple(near.distance_m, near.submap); });
    std::vector<std::size_t> chosen;
    for (const Nearby& near : nearby) {
      if (std::ssize(chosen) >= options.max_candidates) break;
      const bool overlaps = std::ranges::any_of(chosen, [&](std::size_t other) {
        return std::max(other, near.submap) - std::min(other, near.submap) <= 1;
      });
      if (overlaps) continue;
      chosen.push_back(near.submap);
      pairs.push_back({near.submap, query, near.drift});
    }
  }
  std::ranges::sort(
      pairs, {}, [](const LoopPair& pair) { return std::pair(pair.submap, pair.query); });
  return pairs;
}

}  // namespace nightmap
