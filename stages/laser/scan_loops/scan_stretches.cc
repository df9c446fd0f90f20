// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/scan_stretches.h"

#include <algorithm>
#include <utility>

#include "pipeline/geometry/plane_grid.h"

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

// Chooses the submaps of a query. The drift grows with the age of a submap, so that those of
// unknown drift are older than all others, and the oldest of the others has the largest drift.
class PairChooser {
 public:
  PairChooser(const ScanLoopsOptions& options,
              const std::vector<Keyscan>& keyscans,
              const DriftSums& drifts,
              const std::vector<ScanStretch>& submaps)
      : options_(options),
        keyscans_(keyscans),
        drifts_(drifts),
        submaps_(submaps),
        grid_(Places(keyscans, submaps), options.submap_length_m) {}

  void Add(std::size_t query, std::size_t keyscan, std::vector<LoopPair>* pairs) const {
    const double latest_m = keyscans_[keyscan].path_m;
    const auto is_older = [&](const ScanStretch& submap) {
      return keyscans_[submap.end - 1].path_m + options_.min_path_m <= latest_m;
    };
    const auto is_unknown = [&](const ScanStretch& submap) {
      return drifts_.Between(submap.middle, keyscan).IsUnknown();
    };
    const auto older = std::ranges::partition_point(submaps_, is_older);
    const auto known = std::partition_point(submaps_.begin(), older, is_unknown);
    const auto first = static_cast<std::size_t>(known - submaps_.begin());
    const auto end = static_cast<std::size_t>(older - submaps_.begin());
    for (std::size_t i = 0; query % kUnknownSpacing == 0 && i < first; i += 2) {
      pairs->push_back({i, query, drifts_.Between(submaps_[i].middle, keyscan)});
    }
    AddKnown(query, keyscan, first, end, pairs);
  }

 private:
  static std::vector<Eigen::Vector2d> Places(const std::vector<Keyscan>& keyscans,
                                             const std::vector<ScanStretch>& submaps) {
    std::vector<Eigen::Vector2d> places;
    for (const ScanStretch& submap : submaps) {
      places.push_back(keyscans[submap.middle].start_from_robot.translation);
    }
    return places;
  }

  // Submaps of [first, end), the nearest ones first: looks around the query in circles that grow.
  void AddKnown(std::size_t query,
                std::size_t keyscan,
                std::size_t first,
                std::size_t end,
                std::vector<LoopPair>* pairs) const {
    if (first >= end) return;
    constexpr double kRounding_m = 1e-3;
    const double reach_m = Reach_m(drifts_.Between(submaps_[first].middle, keyscan)) + kRounding_m;
    const Eigen::Vector2d& place = keyscans_[keyscan].start_from_robot.translation;
    std::vector<std::size_t> chosen;
    double seen_m = -1;
    for (double radius_m = std::min(reach_m, options_.submap_length_m); seen_m < reach_m;
         seen_m = std::exchange(radius_m, std::min(reach_m, 2 * radius_m))) {
      for (const auto& [apart_m, submap] : InRing(place, seen_m, radius_m, first, end)) {
        if (std::ssize(chosen) >= options_.max_candidates) return;
        const Drift drift = drifts_.Between(submaps_[submap].middle, keyscan);
        if (apart_m > Reach_m(drift) || OverlapsOne(submap, chosen)) continue;
        chosen.push_back(submap);
        pairs->push_back({submap, query, drift});
      }
    }
  }

  double Reach_m(const Drift& drift) const { return options_.max_distance_m + 3 * drift.Sigma_m(); }

  static bool OverlapsOne(std::size_t submap, const std::vector<std::size_t>& chosen) {
    return std::ranges::any_of(chosen, [&](std::size_t other) {
      return std::max(other, submap) - std::min(other, submap) <= 1;
    });
  }

  // Distance and index of those farther away than `seen_m` and at most radius_m, ascending.
  std::vector<std::pair<double, std::size_t>> InRing(const Eigen::Vector2d& place,
                                                     double seen_m,
                                                     double radius_m,
                                                     std::size_t first,
                                                     std::size_t end) const {
    std::vector<std::pair<double, std::size_t>> ring;
    for (const std::size_t submap : grid_.Near(place, radius_m)) {
      if (submap < first || submap >= end) continue;
      const auto& other = keyscans_[submaps_[submap].middle].start_from_robot.translation;
      const double apart_m = (other - place).norm();
      if (apart_m > seen_m) ring.emplace_back(apart_m, submap);
    }
    std::ranges::sort(ring);
    return ring;
  }

  const ScanLoopsOptions& options_;
  const std::vector<Keyscan>& keyscans_;
  const DriftSums& drifts_;
  const std::vector<ScanStretch>& submaps_;
  PlaneGrid grid_;
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
  const PairChooser chooser(options, keyscans, drifts, submaps);
  std::vector<LoopPair> pairs;
  for (std::size_t query = 0; query < queries.size(); ++query) {
    chooser.Add(query, queries[query].middle, &pairs);
  }
  std::ranges::sort(
      pairs, {}, [](const LoopPair& pair) { return std::pair(pair.submap, pair.query); });
  return pairs;
}

}  // namespace nightmap
