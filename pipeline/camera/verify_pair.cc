// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/verify_pair.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "pipeline/camera/match_descriptors.h"
#include "pipeline/camera/static_motion.h"

namespace nightmap {
namespace {

// One frame as the 3-D side (source) or the 2-D side (target) of the matches.
struct Side {
  const FrameFeatures* features;
  const RgbdCamera* camera;
  int FeatureMatch::*index;

  FeatureView Feature(const FeatureMatch& match) const { return features->Feature(match.*index); }
};

int CountWithDepth(const Side& side, const std::vector<FeatureMatch>& matches) {
  int count = 0;
  for (const FeatureMatch& match : matches) count += side.Feature(match).Depth_m() > 0;
  return count;
}

struct Correspondences {
  std::vector<PointMatch> points;
  std::vector<FeatureMatch> matches;  // of these entries
};

Correspondences Lift(const Side& source,
                     const Side& target,
                     const std::vector<FeatureMatch>& matches) {
  Correspondences lifted;
  for (const FeatureMatch& match : matches) {
    const double depth_m = source.Feature(match).Depth_m();
    if (depth_m <= 0) continue;
    lifted.points.push_back(
        {target.Feature(match).Pixel(),
         source.camera->color.BackProjectUndistorted(source.Feature(match).Pixel(), depth_m),
         target.Feature(match).Depth_m(),
         source.camera->noise.Sigma_m(depth_m)});
    lifted.matches.push_back(match);
  }
  return lifted;
}

// One random stream per pair, independent of the order of work.
std::uint64_t PairSeed(int seed, const FramePair& pair) {
  return (static_cast<std::uint64_t>(seed) << 48) ^
         (static_cast<std::uint64_t>(pair.frame_a) << 24) ^
         static_cast<std::uint64_t>(pair.frame_b);
}

std::vector<FeatureMatch> PutativeMatches(const VerifyOptions& options,
                                          const FrameFeatures& a,
                                          const FrameFeatures& b) {
  if (b.IsDescribed()) return MatchDescriptors(a, b, options.kind, options.max_ratio);
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < b.NumFeatures(); ++i) {
    matches.push_back({b.reference_features[static_cast<std::size_t>(i)], i});
  }
  return matches;
}

// The covariance of the inverse pose: transported by the adjoint.
Matrix6d InverseCovariance(const Rigid3& pose, const Matrix6d& covariance) {
  const Matrix6d adjoint = Adjoint(pose.Inverse());
  return adjoint * covariance * adjoint.transpose();
}

PairStatus Judge(const VerifyOptions& options, double spread, const Matrix6d& covariance) {
  if (spread < options.min_spread) return PairStatus::kPoorSpread;
  const Eigen::Matrix3d of_translation = covariance.bottomRightCorner<3, 3>();
  const double variance =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(of_translation, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .z();
  return std::sqrt(variance) > options.max_sigma_m ? PairStatus::kUncertain : PairStatus::kAccepted;
}

}  // namespace

double Spread(const std::vector<Eigen::Vector2d>& pixels, const Camera& camera) {
  if (pixels.size() < 3) return 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& pixel : pixels) mean += pixel;
  mean /= static_cast<double>(pixels.size());
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& pixel : pixels) {
    covariance += (pixel - mean) * (pixel - mean).transpose();
  }
  covariance /= static_cast<double>(pixels.size());
  const double area = static_cast<double>(camera.width) * camera.height;
  return 4 * std::numbers::pi * std::sqrt(std::max(0.0, covariance.determinant())) / area;
}

void VerifyPair(const VerifyOptions& options,
                const FrameFeatures& a,
                const RgbdCamera& camera_a,
                const FrameFeatures& b,
                const RgbdCamera& camera_b,
                FramePair* pair) {
  VerifyMatches(options, PutativeMatches(options, a, b), a, camera_a, b, camera_b, pair);
}

void VerifyMatches(const VerifyOptions& options,
                   const std::vector<FeatureMatch>& putative,
                   const FrameFeatures& a,
                   const RgbdCamera& camera_a,
                   const FrameFeatures& b,
                   const RgbdCamera& camera_b,
                   FramePair* pair) {
  pair->inliers.clear();
  pair->num_putative = static_cast<int>(putative.size());
  pair->status = PairStatus::kTooFewMatches;
  const Side side_a{&a, &camera_a, &FeatureMatch::a};
  const Side side_b{&b, &camera_b, &FeatureMatch::b};
  const bool forward = CountWithDepth(side_a, putative) >= CountWithDepth(side_b, putative);
  const Side& source = forward ? side_a : side_b;
  const Side& target = forward ? side_b : side_a;
  const Correspondences lifted = Lift(source, target, putative);
  if (static_cast<int>(lifted.points.size()) < options.pose.min_inliers) return;

  AbsolutePoseOptions pose_options = options.pose;
  pose_options.noise = target.camera->noise;
  pose_options.seed = PairSeed(options.seed, *pair);
  const auto pose =
      EstimateStaticMotion(target.camera->color, lifted.points, pose_options, options.max_motions);
  pair->status = PairStatus::kTooFewInliers;
  if (!pose) return;

  std::vector<Eigen::Vector2d> pixels;
  for (const int i : pose->inliers) {
    pair->inliers.push_back(lifted.matches[static_cast<std::size_t>(i)]);
    pixels.push_back(lifted.points[static_cast<std::size_t>(i)].pixel);
  }
  pair->b_from_a = forward ? pose->camera_from_world : pose->camera_from_world.Inverse();
  pair->covariance =
      forward ? pose->covariance : InverseCovariance(pose->camera_from_world, pose->covariance);
  pair->status = Judge(options, Spread(pixels, target.camera->color), pair->covariance);
}

}  // namespace nightmap
