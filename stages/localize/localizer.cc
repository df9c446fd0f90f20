// SPDX-License-Identifier: Apache-2.0
#include "stages/localize/localizer.h"

#include "pipeline/base/random.h"

namespace nightmap {

QueryResult FailedQuery(const FrameRecord& query, const std::string& reason) {
  QueryResult result;
  result.query_idx = query.frame_idx;
  result.time_ns = query.time_ns;
  result.color_path = query.color_path;
  result.reason = reason;
  return result;
}

QueryResult Localizer::Localize(const FrameRecord& query,
                                const Camera& camera,
                                const FrameFeatures& features) const {
  if (features.NumFeatures() == 0) return FailedQuery(query, "no_features");
  const std::uint64_t random_seed =
      Random(static_cast<std::uint64_t>(options_.seed), static_cast<std::uint64_t>(query.frame_idx))
          .Next();
  std::vector<LandmarkMatch> matches = matcher_.SearchByWords(features);
  auto located = Estimate(features, camera, matches, random_seed, options_.min_seed_inliers);
  if (!located) {
    matches = matcher_.SearchByRetrieval(features);
    located = Estimate(features, camera, matches, random_seed, options_.min_seed_inliers);
  }
  if (located) located = Refine(features, camera, *located, random_seed);
  const bool few = static_cast<int>(matches.size()) < options_.min_inliers;
  QueryResult result = FailedQuery(query, few ? "too_few_matches" : "too_few_inliers");
  result.num_matches = static_cast<int>(located ? located->matches.size() : matches.size());
  if (!located) return result;
  result.num_inliers = static_cast<int>(located->pose.inliers.size());
  if (result.num_inliers < options_.min_inliers) return result;
  result.reason.clear();
  result.reprojection_error_px = located->pose.rms_error_px;
  result.map_from_camera = located->pose.camera_from_world.Inverse();
  return result;
}

// A second, wider search around the first pose; the better supported of the two poses is kept.
Localizer::Located Localizer::Refine(const FrameFeatures& features,
                                     const Camera& camera,
                                     const Located& first,
                                     std::uint64_t random_seed) const {
  std::vector<int> seen;
  for (const int inlier : first.pose.inliers) {
    seen.push_back(first.matches[static_cast<std::size_t>(inlier)].landmark);
  }
  const auto matches = matcher_.SearchByPose(features, camera, first.pose.camera_from_world, seen);
  const auto second = Estimate(features, camera, matches, random_seed, options_.min_inliers);
  if (!second || second->pose.inliers.size() < first.pose.inliers.size()) return first;
  return *second;
}

std::optional<Localizer::Located> Localizer::Estimate(const FrameFeatures& features,
                                                      const Camera& camera,
                                                      const std::vector<LandmarkMatch>& matches,
                                                      std::uint64_t random_seed,
                                                      int min_inliers) const {
  std::vector<PointMatch> points;
  for (const LandmarkMatch& match : matches) {
    const auto landmark = static_cast<std::size_t>(match.landmark);
    points.push_back({features.keypoints_px[static_cast<std::size_t>(match.feature)].cast<double>(),
                      map_.positions_in_map[landmark]});
  }
  AbsolutePoseOptions pose_options;
  pose_options.max_error_px = options_.max_error_px;
  pose_options.min_inliers = min_inliers;
  pose_options.max_iterations = options_.max_iterations;
  pose_options.seed = random_seed;
  auto pose = EstimateAbsolutePose(camera, points, pose_options);
  if (!pose) return {};
  return Located{std::move(*pose), matches};
}

}  // namespace nightmap
