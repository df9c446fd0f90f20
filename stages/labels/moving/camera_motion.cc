// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/camera_motion.h"

#include <numeric>
#include <vector>

#include "pipeline/camera/follow_corners.h"
#include "pipeline/camera/static_motion.h"

namespace nightmap {
namespace {

constexpr float kMaxWayBack_px = 0.5;
// Labels are sometimes wrong, and who may move may sit still.
constexpr double kWeightOfWhatMayMove = 0.05;

struct Matched {
  std::vector<PointMatch> points;
  std::vector<bool> may_move;
};

Matched Matches(const CameraMotionOptions& options,
                const SmallCamera& camera,
                const SmallFrame& a,
                const SmallFrame& b) {
  const std::vector<Eigen::Vector2f>& corners = a.corners;
  if (corners.empty()) return {};
  const Followed there = Follow(a.pyramid, b.pyramid, corners, {options.window_px});
  const Followed back = Follow(b.pyramid, a.pyramid, there.points, {options.window_px});
  Matched matches;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d seen = there.points[i].cast<double>();
    const double depth_m = DepthAt(a, corners[i]);
    if (!there.is_found[i] || !back.is_found[i] || !camera.gray.Contains(seen)) continue;
    if (Distance_px(back.points[i], corners[i]) > kMaxWayBack_px || depth_m <= 0) continue;
    matches.may_move.push_back(MayMove(a, corners[i]));
    matches.points.push_back({camera.gray.Undistort(seen),
                              camera.gray.BackProject(corners[i].cast<double>(), depth_m),
                              DepthAt(b, there.points[i]),
                              camera.noise.Sigma_m(depth_m)});
  }
  return matches;
}

}  // namespace

std::optional<Rigid3> CameraMotion(const CameraMotionOptions& options,
                                   const SmallCamera& camera,
                                   const SmallFrame& a,
                                   const SmallFrame& b,
                                   std::uint64_t seed) {
  AbsolutePoseOptions pose_options;
  pose_options.max_error_px = options.max_error_px;
  pose_options.max_depth_error = options.max_depth_error;
  pose_options.min_inliers = options.min_inliers;
  pose_options.noise = camera.noise;
  pose_options.seed = seed;
  const auto matches = Matches(options, camera, a, b);
  std::vector<double> weights = SurfaceAreas_m2(camera.gray, matches.points);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (matches.may_move[i]) weights[i] *= kWeightOfWhatMayMove;
  }
  const auto pose = EstimateAbsolutePose(camera.gray, matches.points, pose_options, weights);
  if (!pose) return std::nullopt;
  double agreeing = 0;
  for (const int i : pose->inliers) agreeing += weights[static_cast<std::size_t>(i)];
  if (agreeing < options.min_share * std::accumulate(weights.begin(), weights.end(), 0.0)) {
    return std::nullopt;
  }
  return pose->camera_from_world;
}

}  // namespace nightmap
