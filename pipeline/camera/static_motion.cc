// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/static_motion.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace nightmap {
namespace {

constexpr int kCellsAcross = 24;  // of the picture's width

// The matches that fit no motion so far.
struct Rest {
  std::vector<PointMatch> matches;
  std::vector<int> indices;  // of them among all matches
  std::vector<double> areas_m2;

  double Area_m2() const { return std::accumulate(areas_m2.begin(), areas_m2.end(), 0.0); }

  double Area_m2(const std::vector<int>& inliers) const {
    double sum = 0;
    for (const int i : inliers) sum += areas_m2[static_cast<std::size_t>(i)];
    return sum;
  }

  Rest Without(const std::vector<int>& inliers) const {
    Rest rest;
    auto next = inliers.begin();
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (next != inliers.end() && static_cast<std::size_t>(*next) == i) {
        ++next;
        continue;
      }
      rest.matches.push_back(matches[i]);
      rest.indices.push_back(indices[i]);
      rest.areas_m2.push_back(areas_m2[i]);
    }
    return rest;
  }
};

Rest AllOf(const Camera& camera, const std::vector<PointMatch>& matches) {
  std::vector<int> indices(matches.size());
  std::iota(indices.begin(), indices.end(), 0);
  return {matches, indices, SurfaceAreas_m2(camera, matches)};
}

}  // namespace

std::vector<double> SurfaceAreas_m2(const Camera& camera, const std::vector<PointMatch>& matches) {
  const double cell_px = static_cast<double>(camera.width) / kCellsAcross;
  const int num_rows = static_cast<int>(std::ceil(camera.height / cell_px));
  std::vector<int> counts(static_cast<std::size_t>(kCellsAcross * num_rows));
  const auto count = [&](const PointMatch& match) -> int& {
    // Undistorted pixels may lie outside of the picture; they belong to its border.
    const double column = std::clamp(match.pixel.x() / cell_px, 0.0, kCellsAcross - 1.0);
    const double row = std::clamp(match.pixel.y() / cell_px, 0.0, num_rows - 1.0);
    return counts[static_cast<std::size_t>(static_cast<int>(row) * kCellsAcross +
                                           static_cast<int>(column))];
  };
  for (const PointMatch& match : matches) ++count(match);
  std::vector<double> areas_m2;
  for (const PointMatch& match : matches) {
    const double edge_m = cell_px / camera.fx * match.point_in_world.z();
    areas_m2.push_back(edge_m * edge_m / count(match));
  }
  return areas_m2;
}

std::optional<AbsolutePose> EstimateStaticMotion(const Camera& camera,
                                                 const std::vector<PointMatch>& matches,
                                                 const AbsolutePoseOptions& options,
                                                 int max_motions) {
  Rest rest = AllOf(camera, matches);
  std::optional<AbsolutePose> best;
  double best_area_m2 = 0;
  for (int i = 0; i < max_motions && rest.Area_m2() > best_area_m2; ++i) {
    auto motion = EstimateAbsolutePose(camera, rest.matches, options);
    if (!motion) break;
    const double area_m2 = rest.Area_m2(motion->inliers);
    Rest others = rest.Without(motion->inliers);
    if (!best || area_m2 > best_area_m2) {
      for (int& inlier : motion->inliers) {
        inlier = rest.indices[static_cast<std::size_t>(inlier)];
      }
      best = std::move(motion);
      best_area_m2 = area_m2;
    }
    rest = std::move(others);
  }
  return best;
}

}  // namespace nightmap
