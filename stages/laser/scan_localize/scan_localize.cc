// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/scan_localize.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/parallel.h"
#include "pipeline/laser/thin_points.h"

namespace nightmap {
namespace {

// The lead of the first of two places, 0 .. 1, among the points that only one of them explains.
double Lead(const std::vector<bool>& of_first, const std::vector<bool>& of_second) {
  int votes = 0, lead = 0;
  for (std::size_t i = 0; i < of_first.size(); ++i) {
    votes += of_first[i] != of_second[i];
    lead += of_first[i] - of_second[i];
  }
  return votes == 0 ? 0 : std::max(0.0, static_cast<double>(lead) / votes);
}

void DescribePlace(const std::vector<ScanCandidate>& candidates, QueryResult* result) {
  const ScanCandidate& best = candidates.front();
  const auto count = [](const std::vector<bool>& is) {
    return static_cast<int>(std::ranges::count(is, true));
  };
  result->num_matches = static_cast<int>(best.on_wall.size());
  result->num_inliers = count(best.on_wall);
  result->confidence = static_cast<double>(result->num_inliers) / result->num_matches;
  if (candidates.size() > 1) {
    result->num_rival_inliers = count(candidates[1].on_wall);
    result->confidence = Lead(best.on_wall, candidates[1].on_wall);
  }
  result->map_from_camera = best.map_from_query.ToRigid3();
  result->position_sigma_m = std::sqrt(best.covariance(0, 0) + best.covariance(1, 1));
  result->rotation_sigma_deg = std::sqrt(best.covariance(2, 2)) * 180 / std::numbers::pi;
}

// A rough position whose radius is as large as the map says nothing: the map is searched.
ScanQuery WithUsefulPosition(const ScanMap& map, ScanQuery query) {
  const double diagonal_m = 2 * std::numbers::sqrt2 * map.HalfExtent_m();
  if (query.rough_position && query.rough_position->radius_m >= diagonal_m) {
    query.rough_position.reset();
  }
  return query;
}

LocatedScan Locate(const ScanLocalizeOptions& options,
                   const ScanMap& map,
                   const std::vector<MapObject>& objects,
                   const std::vector<Eigen::Vector2d>& walls_of_objects,
                   const ScanQuery& asked) {
  const bool is_published = options.method == "published";
  const ScanQuery query = WithUsefulPosition(map, asked);
  const auto points =
      ThinPoints(PointsInQuery(query, options.candidates.max_range_m), map.Grid().resolution_m);
  LocatedScan located;
  located.result.time_ns = query.time_ns;
  located.result.color_path = query.name;
  if (points.size() >= static_cast<std::size_t>(options.verdict.min_points)) {
    if (is_published) {
      static_cast<PublishedPlaces&>(located) =
          FindCandidatesAsPublished(options.published, options.candidates, map, objects, query);
    } else {
      located.candidates = FindCandidates(options.candidates, map, walls_of_objects, query);
    }
  }
  const ScanVerdict verdict =
      Judge(options.verdict, query, points.size(), located.candidates, is_published);
  located.result.verdict = verdict.verdict;
  located.result.reason = verdict.reason;
  if (!located.candidates.empty()) DescribePlace(located.candidates, &located.result);
  return located;
}

}  // namespace

std::vector<LocatedScan> RunScanLocalize(const ScanLocalizeOptions& options,
                                         const ScanLocalizeInput& input,
                                         Progress& progress,
                                         int num_threads) {
  const ScanMap map(options.map, input.grid, num_threads);
  const auto walls_of_objects = WallsOfObjects(input.grid, input.objects);
  std::vector<LocatedScan> located(input.queries.size());
  progress.Start(located.size());
  ParallelFor(located.size(), num_threads, [&](std::size_t i) {
    located[i] = Locate(options, map, input.objects, walls_of_objects, input.queries[i]);
    located[i].result.query_idx = static_cast<int>(i);
    progress.Advance();
  });
  progress.Finish();
  return located;
}

}  // namespace nightmap
