// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/localizer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "pipeline/base/random.h"
#include "stages/camera/localize/active_search.h"
#include "stages/camera/localize/map_uncertainty.h"
#include "stages/camera/localize/mirror_features.h"
#include "stages/camera/localize/place_search.h"

namespace nightmap {
namespace {

constexpr int kMinSeedInliers = 8;  // smallest number of inliers of the first pose
// A rival pose within this angle (and distance) is the same view.
constexpr double kSameView_rad = 0.5;

// Features that vote for one of two places: matched only there, or more similar to its landmark.
struct Votes {
  int num_first = 0;
  int num_second = 0;
  int Sum() const { return num_first + num_second; }
  // Significance of the difference if both places were equal (sign test), in standard deviations.
  double Significance() const {
    return Sum() == 0 ? 0 : (num_first - num_second) / std::sqrt(static_cast<double>(Sum()));
  }
  double Lead() const {
    return Sum() == 0 ? 0 : static_cast<double>(num_first - num_second) / Sum();
  }
};

Votes Compare(const std::vector<LandmarkMatch>& first, const std::vector<LandmarkMatch>& second) {
  std::map<int, int> distances;
  for (const LandmarkMatch& match : second) distances[match.feature] = match.distance;
  Votes votes;
  for (const LandmarkMatch& match : first) {
    const auto other = distances.find(match.feature);
    votes.num_first += other == distances.end() || match.distance < other->second;
    votes.num_second += other != distances.end() && other->second < match.distance;
    if (other != distances.end()) distances.erase(other);
  }
  votes.num_second += static_cast<int>(distances.size());
  return votes;
}

}  // namespace

QueryResult FailedQuery(const FrameRecord& query, QueryVerdict verdict, const std::string& reason) {
  QueryResult result;
  result.query_idx = query.frame_idx;
  result.time_ns = query.time_ns;
  result.color_path = query.color.path;
  result.verdict = verdict;
  result.reason = reason;
  return result;
}

std::vector<LandmarkMatch> Localizer::Located::Inliers() const {
  std::vector<LandmarkMatch> inliers;
  for (const int i : pose.inliers) inliers.push_back(matches[static_cast<std::size_t>(i)]);
  return inliers;
}

double Localizer::Located::InlierSignificance() const {
  const auto num_matches = static_cast<double>(matches.size());
  const double deviation = std::sqrt(num_matches * chance_ratio * (1 - chance_ratio));
  if (deviation == 0) return std::numeric_limits<double>::infinity();
  return (NumInliers() - chance_ratio * num_matches) / deviation;
}

QueryResult Localizer::Localize(const FrameRecord& query,
                                const PictureLens& lens,
                                const FrameFeatures& features) const {
  if (features.NumFeatures() == 0) {
    return FailedQuery(query, QueryVerdict::kNoFeatures, "no_features");
  }
  const Picture picture{
      lens,
      features,
      Random(static_cast<std::uint64_t>(options_.seed), static_cast<std::uint64_t>(query.frame_idx))
          .Next(),
      LensesToTry(lens)};
  int num_matches = 0;
  auto located = SearchAndEstimate(picture, &num_matches);
  if (!located) located = SearchRetrieved(picture, &num_matches);
  if (located) located = SearchAround(picture, *located);
  const bool few = num_matches < options_.min_inliers;
  QueryResult result =
      FailedQuery(query, QueryVerdict::kNotInMap, few ? "too_few_matches" : "too_few_inliers");
  result.num_matches = num_matches;
  if (IsMirrored(picture, located)) {
    result.reason = "mirrored";
  } else if (located) {
    Judge(picture, *std::move(located), &result);
  }
  return result;
}

std::optional<Localizer::Located> Localizer::SearchAndEstimate(const Picture& picture,
                                                               int* num_matches) const {
  auto matches = ActiveSearch(options_, index_, picture.features).Run();
  *num_matches = static_cast<int>(matches.size());
  if (options_.covisibility_filter && !matches.empty()) matches = LargestPlace(index_, matches);
  return Estimate(picture, matches, kMinSeedInliers);
}

std::optional<Localizer::Located> Localizer::SearchRetrieved(const Picture& picture,
                                                             int* num_matches) const {
  std::optional<Located> best;
  if (options_.num_retrieved_keyframes == 0) return best;
  for (const auto& matches : SearchByRetrieval(options_, index_, picture.features)) {
    *num_matches = std::max(*num_matches, static_cast<int>(matches.size()));
    auto located = Estimate(picture, matches, kMinSeedInliers);
    if (located && (!best || located->NumInliers() > best->NumInliers())) best = std::move(located);
  }
  return best;
}

// Repeats the search around the first pose with a wider reach; keeps the pose with more support.
Localizer::Located Localizer::SearchAround(const Picture& picture, const Located& first) const {
  if (options_.num_guided_keyframes == 0) return first;
  std::vector<int> seen;
  for (const LandmarkMatch& match : first.Inliers()) seen.push_back(match.landmark);
  const auto matches = SearchByPose(
      options_, index_, picture.features, first.camera, first.pose.camera_from_world, seen);
  Picture same_lens = picture;
  same_lens.starts = {first.camera};
  auto second = Estimate(same_lens, matches, options_.min_inliers);
  if (!second || second->NumInliers() < first.NumInliers()) return first;
  // A wrong match, too, lies within the radius of its landmark's projection by the first pose.
  second->chance_ratio =
      std::pow(std::min(1.0, options_.max_error_px / options_.guided_radius_px), 2);
  return *std::move(second);
}

std::optional<Localizer::Located> Localizer::SearchRival(const Picture& picture,
                                                         const Located& located) const {
  if (options_.max_rival_ratio >= 1) return {};
  const auto matches = SearchRivals(options_, index_, picture.features, located.Inliers());
  // A rival that explains as much in the end matches more than a tenth of it here.
  const double num_enough = 0.1 * options_.max_rival_ratio * located.NumInliers();
  Picture same_lens = picture;
  same_lens.starts = {located.camera};
  const auto first =
      Estimate(same_lens, matches, std::max(kMinSeedInliers, static_cast<int>(num_enough)));
  if (!first) return {};
  Located rival = SearchAround(picture, *first);
  const Rigid3 map_from_camera = located.pose.camera_from_world.Inverse();
  const Rigid3 map_from_rival = rival.pose.camera_from_world.Inverse();
  const double apart_m = (map_from_camera.translation - map_from_rival.translation).norm();
  const bool is_same = apart_m < options_.rival_distance_m &&
                       AngleBetween_rad(map_from_camera, map_from_rival) < kSameView_rad;
  if (is_same) return {};
  return rival;
}

bool Localizer::IsInMap(const Located& located) const {
  return located.NumInliers() >= options_.min_inliers &&
         located.InlierSignificance() >= options_.min_inlier_significance;
}

bool Localizer::IsMirrored(const Picture& picture, const std::optional<Located>& located) const {
  const auto features = MirrorFeatures(picture.features, index_.Map().kind, picture.lens.camera);
  if (!features) return false;
  const Picture mirror_image{picture.lens, *features, picture.random_seed, picture.starts};
  int num_matches = 0;
  const auto first = SearchAndEstimate(mirror_image, &num_matches);
  if (!first) return false;
  const Located mirrored = SearchAround(mirror_image, *first);
  const Votes votes =
      Compare(mirrored.Inliers(), located ? located->Inliers() : std::vector<LandmarkMatch>{});
  return IsInMap(mirrored) && votes.Significance() >= options_.min_rival_significance;
}

void Localizer::Judge(const Picture& picture, Located located, QueryResult* result) const {
  auto rival = SearchRival(picture, located);
  Votes votes{located.NumInliers(), 0};
  if (rival) {
    votes = Compare(located.Inliers(), rival->Inliers());
    if (votes.num_second > votes.num_first && rival->NumInliers() >= options_.min_inliers) {
      std::swap(located, *rival);
      std::swap(votes.num_first, votes.num_second);
    }
    result->num_rival_inliers = rival->NumInliers();
  }
  FillPose(located, result);
  if (!IsInMap(located)) return;
  if (!(result->position_sigma_m <= options_.max_position_sigma_m)) {
    result->reason = "uncertain_pose";
    return;
  }
  const double chance = static_cast<double>(options_.min_inliers) / result->num_inliers;
  const double doubt = result->position_sigma_m / options_.max_position_sigma_m;
  result->confidence = std::max(0.0, std::min({1 - chance, votes.Lead(), 1 - doubt}));
  const bool is_ambiguous =
      result->num_rival_inliers > options_.max_rival_ratio * result->num_inliers &&
      votes.Significance() < options_.min_rival_significance;
  result->verdict = is_ambiguous ? QueryVerdict::kAmbiguous : QueryVerdict::kLocated;
  result->reason = is_ambiguous ? "rival_place" : "";
  // Last, so that verdicts are those of poses without motion.
  auto moving = AllowMotion(options_, picture.lens, Points(picture, located.matches), located);
  if (moving) static_cast<PicturePose&>(located) = *std::move(moving);
  FillPose(located, result);
}

void Localizer::FillPose(const Located& located, QueryResult* result) const {
  std::vector<int> seen;
  for (const LandmarkMatch& match : located.Inliers()) seen.push_back(match.landmark);
  const Matrix6d covariance =
      located.pose.covariance + MapCovariance(index_.Map(), seen, located.pose.camera_from_world);
  result->num_matches = static_cast<int>(located.matches.size());
  result->num_inliers = located.NumInliers();
  result->reprojection_error_px = located.pose.rms_error_px;
  // The camera's position changes by the rotated translation of the left perturbation.
  result->position_sigma_m = std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
  result->rotation_sigma_deg =
      std::sqrt(covariance.topLeftCorner<3, 3>().trace()) * 180 / std::numbers::pi;
  result->map_from_camera = located.pose.camera_from_world.Inverse();
}

std::vector<PointMatch> Localizer::Points(const Picture& picture,
                                          const std::vector<LandmarkMatch>& matches) const {
  std::vector<PointMatch> points;
  for (const LandmarkMatch& match : matches) {
    points.push_back(
        {picture.features.Feature(match.feature).Pixel(), index_.Position(match.landmark)});
  }
  return points;
}

std::optional<Localizer::Located> Localizer::Estimate(const Picture& picture,
                                                      const std::vector<LandmarkMatch>& matches,
                                                      int min_inliers) const {
  auto found = EstimatePicturePose(options_,
                                   picture.lens,
                                   picture.starts,
                                   Points(picture, matches),
                                   min_inliers,
                                   picture.random_seed);
  if (!found) return {};
  return Located{*std::move(found), matches};
}

}  // namespace nightmap
