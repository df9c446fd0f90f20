// SPDX-License-Identifier: Apache-2.0
// EstimateAbsolutePose against OpenCV's robust estimators: the relative pose of pairs of frames
// from all their putative matches, compared with the truth.
#include <fmt/format.h>

#include <algorithm>
#include <opencv2/calib3d.hpp>

#include "pipeline/base/parallel.h"
#include "pipeline/camera/match_descriptors.h"
#include "pipeline/geometry/absolute_pose.h"
#include "tests/bench/libraries/compare.h"
#include "tests/bench/libraries/comparisons.h"
#include "tests/bench/libraries/to_opencv.h"

namespace nightmap {
namespace {

constexpr std::size_t kNumPairs = 200;

struct PosePair {
  const Camera* camera = nullptr;  // of b
  AbsolutePoseOptions options;
  std::vector<PointMatch> matches;  // points of a, pixels of b
  std::vector<cv::Point3f> points;  // the same for OpenCV
  std::vector<cv::Point2f> pixels_a, pixels_b;
  Rigid3 b_from_a;  // truth
};

using Poses = std::vector<std::optional<Rigid3>>;

std::vector<PosePair> MakePairs(const MappedSite& site) {
  std::vector<PosePair> pairs;
  for (const FramePair& frames : EvenlySpaced(site.loops, kNumPairs)) {
    const auto time = [&](int i) { return site.frames[static_cast<std::size_t>(i)].time_ns; };
    const int truth_a = FindPose(site.truth, time(frames.frame_a));
    const int truth_b = FindPose(site.truth, time(frames.frame_b));
    if (truth_a < 0 || truth_b < 0) continue;
    PosePair& pair = pairs.emplace_back();
    pair.b_from_a = site.truth[static_cast<std::size_t>(truth_b)].pose.Inverse() *
                    site.truth[static_cast<std::size_t>(truth_a)].pose;
    const RgbdCamera& camera_a = site.CameraOf(frames.frame_a);
    const RgbdCamera& camera_b = site.CameraOf(frames.frame_b);
    pair.camera = &camera_b.color;
    pair.options.noise = camera_b.noise;
    const FrameFeatures& a = site.FeaturesOf(frames.frame_a);
    const FrameFeatures& b = site.FeaturesOf(frames.frame_b);
    for (const FeatureMatch& match : MatchDescriptors(a, b, site.features.kind, 0.85)) {
      const FeatureView of_a = a.Feature(match.a);
      const FeatureView of_b = b.Feature(match.b);
      if (of_a.Depth_m() <= 0) continue;
      const Eigen::Vector3d point =
          camera_a.color.BackProjectUndistorted(of_a.Pixel(), of_a.Depth_m());
      pair.matches.push_back(
          {of_b.Pixel(), point, of_b.Depth_m(), camera_a.noise.Sigma_m(of_a.Depth_m())});
      pair.points.emplace_back(ToPoint(point));
      pair.pixels_a.emplace_back(ToPoint(of_a.Pixel()));
      pair.pixels_b.emplace_back(ToPoint(of_b.Pixel()));
    }
  }
  return pairs;
}

std::optional<Rigid3> Ours(const PosePair& pair) {
  const auto pose = EstimateAbsolutePose(*pair.camera, pair.matches, pair.options);
  return pose ? std::optional(pose->camera_from_world) : std::nullopt;
}

std::optional<Rigid3> Magsac(const PosePair& pair) {
  cv::UsacParams params;
  params.score = cv::SCORE_METHOD_MAGSAC;
  params.loMethod = cv::LOCAL_OPTIM_SIGMA;
  params.confidence = pair.options.confidence;
  params.maxIterations = pair.options.max_iterations;
  params.threshold = pair.options.max_error_px;
  cv::Mat camera = CameraMatrix(*pair.camera);
  cv::Mat rotation, translation, inliers;
  if (!cv::solvePnPRansac(pair.points,
                          pair.pixels_b,
                          camera,
                          cv::noArray(),
                          rotation,
                          translation,
                          inliers,
                          params)) {
    return std::nullopt;
  }
  return ToPose(rotation, translation);
}

// RANSAC over AP3P, and Levenberg-Marquardt on its inliers.
std::optional<Rigid3> RansacAndRefinement(const PosePair& pair) {
  const cv::Mat camera = CameraMatrix(*pair.camera);
  cv::Mat rotation, translation;
  std::vector<int> inliers;
  if (!cv::solvePnPRansac(pair.points,
                          pair.pixels_b,
                          camera,
                          cv::noArray(),
                          rotation,
                          translation,
                          false,
                          pair.options.max_iterations,
                          static_cast<float>(pair.options.max_error_px),
                          pair.options.confidence,
                          inliers,
                          cv::SOLVEPNP_AP3P)) {
    return std::nullopt;
  }
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2f> pixels;
  for (const int i : inliers) {
    points.push_back(pair.points[static_cast<std::size_t>(i)]);
    pixels.push_back(pair.pixels_b[static_cast<std::size_t>(i)]);
  }
  cv::solvePnPRefineLM(points, pixels, camera, cv::noArray(), rotation, translation);
  return ToPose(rotation, translation);
}

// From pixels alone; the length of the translation is not known.
std::optional<Rigid3> Essential(const PosePair& pair) {
  const cv::Mat camera = CameraMatrix(*pair.camera);
  if (pair.pixels_a.size() < 8) return std::nullopt;
  cv::Mat inliers;
  const cv::Mat essential = cv::findEssentialMat(
      pair.pixels_a, pair.pixels_b, camera, cv::USAC_MAGSAC, pair.options.confidence, 1.0, inliers);
  if (essential.rows != 3) return std::nullopt;
  cv::Mat rotation, translation, rotation_vector;
  cv::recoverPose(essential, pair.pixels_a, pair.pixels_b, camera, rotation, translation, inliers);
  cv::Rodrigues(rotation, rotation_vector);
  return ToPose(rotation_vector, translation);
}

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::ranges::nth_element(values, values.begin() + at);
  return values[static_cast<std::size_t>(at)];
}

// Median and 90th percentile against the truth, over the pairs that got a pose.
std::string Errors(const std::vector<PosePair>& pairs, const Poses& poses, bool with_translation) {
  std::vector<double> degrees, millimetres;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!poses[i]) continue;
    degrees.push_back(AngleBetween_rad(*poses[i], pairs[i].b_from_a) * 180 / M_PI);
    millimetres.push_back(
        1e3 * (poses[i]->Inverse().translation - pairs[i].b_from_a.Inverse().translation).norm());
  }
  std::string text =
      fmt::format("{:.2f}° ({:.2f}°)", Quantile(degrees, 0.5), Quantile(degrees, 0.9));
  if (with_translation) {
    text += fmt::format(
        " {:.1f} mm ({:.1f} mm)", Quantile(millimetres, 0.5), Quantile(millimetres, 0.9));
  }
  return text + fmt::format(", {} failed", poses.size() - degrees.size());
}

void Compare(const std::vector<PosePair>& pairs,
             const std::string& other,
             const std::string& input,
             bool with_translation,
             const std::function<std::optional<Rigid3>(const PosePair&)>& estimate) {
  Poses ours(pairs.size()), theirs(pairs.size());
  const auto run = [&](Poses& poses, const auto& method, int num_threads) {
    cv::setNumThreads(1);
    ParallelFor(pairs.size(), num_threads, [&](std::size_t i) { poses[i] = method(pairs[i]); });
  };
  PrintComparison({.ours = "`EstimateAbsolutePose`",
                   .other = other,
                   .input = input,
                   .run_ours = [&](int num_threads) { run(ours, Ours, num_threads); },
                   .run_other = [&](int num_threads) { run(theirs, estimate, num_threads); },
                   .difference =
                       [&] {
                         return "error " + Errors(pairs, ours, with_translation) + "; X " +
                                Errors(pairs, theirs, with_translation);
                       },
                   .num_items = static_cast<double>(pairs.size())});
}

}  // namespace

void ComparePoses(const MappedSite& site) {
  const std::vector<PosePair> pairs = MakePairs(site);
  const std::string input = fmt::format("{}: pair of frames, of {} loops", site.name, pairs.size());
  Compare(pairs, "`cv::solvePnPRansac`, MAGSAC", input, true, Magsac);
  Compare(pairs,
          "`cv::solvePnPRansac`, AP3P, and `solvePnPRefineLM`",
          input,
          true,
          RansacAndRefinement);
  Compare(pairs, "`cv::findEssentialMat`, MAGSAC, and `recoverPose`", input, false, Essential);
}

}  // namespace nightmap
