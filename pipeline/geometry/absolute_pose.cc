// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/absolute_pose.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "pipeline/base/random.h"
#include "pipeline/geometry/dlt.h"
#include "pipeline/geometry/levenberg_marquardt.h"
#include "pipeline/geometry/reprojection.h"

namespace nightmap {
namespace {

// The estimation problem with all that stays fixed during it.
class Estimator {
 public:
  Estimator(const Camera& camera,
            const std::vector<PointMatch>& matches,
            const AbsolutePoseOptions& options,
            const std::vector<double>& weights)
      : camera_(camera),
        matches_(matches),
        options_(options),
        weights_(weights),
        sums_(weights.size()),
        random_(options.seed) {
    std::partial_sum(weights.begin(), weights.end(), sums_.begin());
  }

  std::optional<AbsolutePose> Estimate();
  std::optional<AbsolutePose> FinishFrom(const Rigid3& camera_from_world) const;
  NormalEquations<6> Equations(const Rigid3& camera_from_world,
                               const std::vector<int>& inliers) const;

 private:
  // Weighted sum of truncated squared reprojection errors (MSAC); lower is better.
  struct Score {
    double cost = std::numeric_limits<double>::max();
    int num_inliers = 0;
    double weight = 0;  // of the inliers
  };

  std::vector<Rigid3> SolveMinimal() {
    return options_.solver == MinimalSolver::kDlt6 ? SampleDlt() : SampleP3p();
  }
  std::vector<Rigid3> SampleP3p();
  std::vector<Rigid3> SampleDlt();
  // Draws a match, as often as its weight says.
  std::size_t Draw();
  double Weight(std::size_t i) const { return weights_.empty() ? 1 : weights_[i]; }
  int SampleSize() const { return options_.solver == MinimalSolver::kDlt6 ? kDltSampleSize : 3; }
  // Not inlined: in the loop over all matches GCC 12 would store the point in halves and wait to
  // load it whole, which makes the stage `matches` 15 % slower.
  [[gnu::noinline]] std::optional<double> SquaredError_px(const Rigid3& camera_from_world,
                                                          const PointMatch& match) const;
  Score Evaluate(const Rigid3& camera_from_world) const;
  std::vector<int> Inliers(const Rigid3& camera_from_world) const;
  Rigid3 Refine(const Rigid3& camera_from_world,
                const std::vector<int>& inliers,
                int num_steps) const;
  void OptimizeLocally(Rigid3* camera_from_world, Score* score) const;
  int RequiredIterations(double inlier_ratio) const;
  double InlierRatio(const Score& score) const;
  AbsolutePose Finish(const Rigid3& camera_from_world, int num_iterations) const;

  const Camera& camera_;
  const std::vector<PointMatch>& matches_;
  const AbsolutePoseOptions& options_;
  const std::vector<double>& weights_;
  std::vector<double> sums_;  // of the weights so far
  Random random_;
};

std::size_t Estimator::Draw() {
  if (sums_.empty()) return random_.Index(matches_.size());
  const auto found = std::ranges::upper_bound(sums_, random_.Uniform(0, sums_.back()));
  return std::min(static_cast<std::size_t>(found - sums_.begin()), sums_.size() - 1);
}

// Draws distinct matches, because five determine nothing.
std::vector<Rigid3> Estimator::SampleDlt() {
  std::vector<std::size_t> sample;
  while (sample.size() < kDltSampleSize) {
    const std::size_t i = random_.Index(matches_.size());
    if (std::ranges::find(sample, i) == sample.end()) sample.push_back(i);
  }
  std::vector<Eigen::Vector2d> rays;
  std::vector<Eigen::Vector3d> points;
  for (const std::size_t i : sample) {
    const PointMatch& match = matches_[i];
    rays.push_back(camera_.BackProjectUndistorted(match.pixel, 1).head<2>());
    points.push_back(match.point_in_world);
  }
  const auto pose = SolveDlt(rays, points);
  return pose ? std::vector<Rigid3>{*pose} : std::vector<Rigid3>{};
}

std::vector<Rigid3> Estimator::SampleP3p() {
  cv::Matx<double, 3, 3> points;
  cv::Matx<double, 3, 2> rays;
  for (int i = 0; i < 3; ++i) {
    const PointMatch& match = matches_[Draw()];
    for (int k = 0; k < 3; ++k) points(i, k) = match.point_in_world[k];
    rays(i, 0) = (match.pixel.x() - camera_.cx) / camera_.fx;
    rays(i, 1) = (match.pixel.y() - camera_.cy) / camera_.fy;
  }
  std::vector<cv::Mat> rotations;
  std::vector<cv::Mat> translations;
  cv::solveP3P(cv::Mat(points),
               cv::Mat(rays),
               cv::Matx33d::eye(),
               cv::noArray(),
               rotations,
               translations,
               cv::SOLVEPNP_AP3P);
  std::vector<Rigid3> poses;
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3d> axis(rotations[i].ptr<double>());
    const Eigen::Map<const Eigen::Vector3d> translation(translations[i].ptr<double>());
    if (!axis.allFinite() || !translation.allFinite()) continue;
    const double angle = axis.norm();
    const Eigen::AngleAxisd rotation(
        angle, angle > 0 ? Eigen::Vector3d(axis / angle) : Eigen::Vector3d::UnitX());
    poses.push_back({Eigen::Quaterniond(rotation), translation});
  }
  return poses;
}

// Nothing when the match is an outlier.
std::optional<double> Estimator::SquaredError_px(const Rigid3& camera_from_world,
                                                 const PointMatch& match) const {
  const Eigen::Vector3d point = camera_from_world * match.point_in_world;
  if (point.z() < Reprojection::kMinDepth_m) return std::nullopt;
  const double error = (*camera_.ProjectUndistorted(point) - match.pixel).squaredNorm();
  if (error > options_.max_error_px * options_.max_error_px) return std::nullopt;
  const double max_depth_error_m =
      options_.max_depth_error * match.depth_m + 3 * options_.noise.Sigma_m(match.depth_m);
  if (match.depth_m > 0 && std::abs(point.z() - match.depth_m) > max_depth_error_m) {
    return std::nullopt;
  }
  return error;
}

Estimator::Score Estimator::Evaluate(const Rigid3& camera_from_world) const {
  Score score{0, 0, 0};
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    const auto error = SquaredError_px(camera_from_world, matches_[i]);
    score.num_inliers += error.has_value();
    score.weight += error ? Weight(i) : 0;
    score.cost += Weight(i) * error.value_or(options_.max_error_px * options_.max_error_px);
  }
  return score;
}

std::vector<int> Estimator::Inliers(const Rigid3& camera_from_world) const {
  std::vector<int> inliers;
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    if (SquaredError_px(camera_from_world, matches_[i])) inliers.push_back(static_cast<int>(i));
  }
  return inliers;
}

NormalEquations<6> Estimator::Equations(const Rigid3& camera_from_world,
                                        const std::vector<int>& inliers) const {
  NormalEquations<6> equations;
  for (const int i : inliers) {
    const PointMatch& match = matches_[static_cast<std::size_t>(i)];
    const Reprojection seen(camera_, camera_from_world * match.point_in_world);
    if (!seen.IsVisible()) continue;
    const double depth_sigma_m =
        std::hypot(options_.noise.Sigma_m(match.depth_m), match.point_sigma_m);
    const PointMeasurement measured{match.pixel,
                                    match.depth_m,
                                    1 / options_.pixel_sigma_px,
                                    match.depth_m > 0 ? 1 / depth_sigma_m : 0.0};
    equations.AddRobust(seen.ByPose(seen.ByMovedPoint(measured)), seen.Residual(measured));
  }
  return equations;
}

Rigid3 Estimator::Refine(const Rigid3& pose, const std::vector<int>& inliers, int num_steps) const {
  return MinimizeSmall<6>(
      {.max_steps = num_steps, .min_step = 1e-8},
      pose,
      [&](const Rigid3& camera_from_world) { return Equations(camera_from_world, inliers); },
      PerturbLeft);
}

double Estimator::InlierRatio(const Score& score) const {
  return weights_.empty()
             ? static_cast<double>(score.num_inliers) / static_cast<double>(matches_.size())
             : score.weight / sums_.back();
}

int Estimator::RequiredIterations(double inlier_ratio) const {
  const double miss = std::max(1e-12, 1 - std::pow(inlier_ratio, SampleSize()));
  if (miss >= 1) return options_.max_iterations;
  const double required = std::log(1 - options_.confidence) / std::log(miss);
  return static_cast<int>(
      std::clamp(required,
                 static_cast<double>(std::min(options_.min_iterations, options_.max_iterations)),
                 static_cast<double>(options_.max_iterations)));
}

AbsolutePose Estimator::Finish(const Rigid3& camera_from_world, int num_iterations) const {
  AbsolutePose result;
  result.camera_from_world = options_.refinement
                                 ? Refine(camera_from_world, Inliers(camera_from_world), 20)
                                 : camera_from_world;
  result.inliers = Inliers(result.camera_from_world);
  result.num_iterations = num_iterations;
  result.covariance = Equations(result.camera_from_world, result.inliers)
                          .Covariance()
                          .value_or(Matrix6d::Identity());
  double sum = 0;
  for (const int i : result.inliers) {
    sum += SquaredError_px(result.camera_from_world, matches_[static_cast<std::size_t>(i)])
               .value_or(0);
  }
  result.rms_error_px =
      std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, result.inliers.size())));
  return result;
}

void Estimator::OptimizeLocally(Rigid3* pose, Score* score) const {
  const Rigid3 refined = Refine(*pose, Inliers(*pose), 4);
  const Score refined_score = Evaluate(refined);
  if (refined_score.cost >= score->cost) return;
  *pose = refined;
  *score = refined_score;
}

std::optional<AbsolutePose> Estimator::Estimate() {
  Score best;
  Rigid3 best_pose;
  // Enough iterations to find any pose with min_inliers; a pose with fewer is refused anyway.
  int num_required = RequiredIterations(static_cast<double>(options_.min_inliers) /
                                        static_cast<double>(matches_.size()));
  int iteration = 0;
  for (; iteration < num_required; ++iteration) {
    for (const Rigid3& pose : SolveMinimal()) {
      const Score score = Evaluate(pose);
      if (score.cost >= best.cost || score.num_inliers <= SampleSize()) continue;
      best = score;
      best_pose = pose;
      if (options_.local_optimization) OptimizeLocally(&best_pose, &best);
      num_required = RequiredIterations(InlierRatio(best));
    }
  }
  if (best.num_inliers < options_.min_inliers) return std::nullopt;
  AbsolutePose result = Finish(best_pose, iteration);
  if (static_cast<int>(result.inliers.size()) < options_.min_inliers) return std::nullopt;
  return result;
}

// Starts with all matches, outliers weighted little, because the start may be too far off to tell
// outliers apart.
std::optional<AbsolutePose> Estimator::FinishFrom(const Rigid3& camera_from_world) const {
  std::vector<int> all(matches_.size());
  std::iota(all.begin(), all.end(), 0);
  AbsolutePose result = Finish(Refine(camera_from_world, all, 10), 0);
  if (static_cast<int>(result.inliers.size()) < options_.min_inliers) return std::nullopt;
  return result;
}

}  // namespace

std::optional<AbsolutePose> EstimateAbsolutePose(const Camera& camera,
                                                 const std::vector<PointMatch>& matches,
                                                 const AbsolutePoseOptions& options,
                                                 const std::vector<double>& weights) {
  const int sample_size = options.solver == MinimalSolver::kDlt6 ? kDltSampleSize : 3;
  if (static_cast<int>(matches.size()) < std::max(sample_size + 1, options.min_inliers)) {
    return std::nullopt;
  }
  return Estimator(camera, matches, options, weights).Estimate();
}

std::optional<AbsolutePose> RefineAbsolutePose(const Camera& camera,
                                               const std::vector<PointMatch>& matches,
                                               const Rigid3& camera_from_world,
                                               const AbsolutePoseOptions& options) {
  if (static_cast<int>(matches.size()) < std::max(4, options.min_inliers)) return std::nullopt;
  return Estimator(camera, matches, options, {}).FinishFrom(camera_from_world);
}

std::optional<Matrix6d> PoseCovariance(const Camera& camera,
                                       const std::vector<PointMatch>& matches,
                                       const Rigid3& camera_from_world,
                                       const AbsolutePoseOptions& options) {
  std::vector<int> all(matches.size());
  std::iota(all.begin(), all.end(), 0);
  return Estimator(camera, matches, options, {}).Equations(camera_from_world, all).Covariance();
}

}  // namespace nightmap
