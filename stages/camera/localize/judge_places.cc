// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/judge_places.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "stages/camera/localize/map_uncertainty.h"

namespace nightmap {
namespace {

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

// Keeps the one with more inliers; the first of equal ones.
void KeepBetter(std::optional<Place> place, std::optional<Place>* best) {
  if (place && (!*best || place->NumInliers() > (*best)->NumInliers())) *best = std::move(place);
}

FoundPlaces Join(const LocalizeOptions& options, std::vector<FoundPlaces> of_parts) {
  FoundPlaces all;
  std::vector<std::optional<Place>> others;
  for (FoundPlaces& part : of_parts) {
    all.num_matches = std::max(all.num_matches, part.num_matches);
    KeepBetter(std::move(part.mirrored), &all.mirrored);
    if (part.located && all.located && part.located->NumInliers() > all.located->NumInliers()) {
      std::swap(part.located, all.located);
    }
    if (!all.located) all.located = std::exchange(part.located, {});
    others.push_back(std::move(part.located));
    others.push_back(std::move(part.rival));
  }
  for (std::optional<Place>& other : others) {
    if (other && !IsSameView(options, *all.located, *other)) {
      KeepBetter(std::move(other), &all.rival);
    }
  }
  return all;
}

void FillPose(const Place& place, QueryResult* result) {
  const Matrix6d covariance = place.pose.covariance + MapCovariance(place);
  result->num_matches = static_cast<int>(place.matches.size());
  result->num_inliers = place.NumInliers();
  result->reprojection_error_px = place.pose.rms_error_px;
  // The camera's position changes by the rotated translation of the left perturbation.
  result->position_sigma_m = std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
  result->rotation_sigma_deg =
      std::sqrt(covariance.topLeftCorner<3, 3>().trace()) * 180 / std::numbers::pi;
  result->map_from_camera = place.pose.camera_from_world.Inverse();
}

void Judge(const LocalizeOptions& options,
           const PictureLens& lens,
           Place located,
           std::optional<Place> rival,
           QueryResult* result) {
  Votes votes{located.NumInliers(), 0};
  if (rival) {
    votes = Compare(located.Inliers(), rival->Inliers());
    if (votes.num_second > votes.num_first && rival->NumInliers() >= options.min_inliers) {
      std::swap(located, *rival);
      std::swap(votes.num_first, votes.num_second);
    }
    result->num_rival_inliers = rival->NumInliers();
  }
  FillPose(located, result);
  if (!IsInMap(options, located)) return;
  if (!(result->position_sigma_m <= options.max_position_sigma_m)) {
    result->reason = "uncertain_pose";
    return;
  }
  const double chance = static_cast<double>(options.min_inliers) / result->num_inliers;
  const double doubt = result->position_sigma_m / options.max_position_sigma_m;
  result->confidence = std::max(0.0, std::min({1 - chance, votes.Lead(), 1 - doubt}));
  const bool is_ambiguous =
      result->num_rival_inliers > options.max_rival_ratio * result->num_inliers &&
      votes.Significance() < options.min_rival_significance;
  result->verdict = is_ambiguous ? QueryVerdict::kAmbiguous : QueryVerdict::kLocated;
  result->reason = is_ambiguous ? "rival_place" : "";
  // Last, so that verdicts are those of poses without motion.
  auto moving = AllowMotion(options, lens, located.points, located);
  if (moving) static_cast<PicturePose&>(located) = *std::move(moving);
  FillPose(located, result);
}

}  // namespace

std::vector<LandmarkMatch> Place::Inliers() const {
  std::vector<LandmarkMatch> inliers;
  for (const int i : pose.inliers) inliers.push_back(matches[static_cast<std::size_t>(i)]);
  return inliers;
}

double Place::InlierSignificance() const {
  const auto num_matches = static_cast<double>(matches.size());
  const double deviation = std::sqrt(num_matches * chance_ratio * (1 - chance_ratio));
  if (deviation == 0) return std::numeric_limits<double>::infinity();
  return (NumInliers() - chance_ratio * num_matches) / deviation;
}

bool IsInMap(const LocalizeOptions& options, const Place& place) {
  return place.NumInliers() >= options.min_inliers &&
         place.InlierSignificance() >= options.min_inlier_significance;
}

bool IsSameView(const LocalizeOptions& options, const Place& a, const Place& b) {
  const Rigid3 map_from_a = a.pose.camera_from_world.Inverse();
  const Rigid3 map_from_b = b.pose.camera_from_world.Inverse();
  return (map_from_a.translation - map_from_b.translation).norm() < options.rival_distance_m &&
         AngleBetween_rad(map_from_a, map_from_b) < kSameView_rad;
}

bool IsMirrored(const LocalizeOptions& options, const FoundPlaces& places) {
  if (!places.mirrored) return false;
  const Votes votes =
      Compare(places.mirrored->Inliers(),
              places.located ? places.located->Inliers() : std::vector<LandmarkMatch>{});
  return IsInMap(options, *places.mirrored) &&
         votes.Significance() >= options.min_rival_significance;
}

QueryResult FailedQuery(const FrameRecord& query, QueryVerdict verdict, const std::string& reason) {
  QueryResult result;
  result.query_idx = query.frame_idx;
  result.time_ns = query.time_ns;
  result.color_path = query.color.path;
  result.verdict = verdict;
  result.reason = reason;
  return result;
}

QueryResult JudgePlaces(const LocalizeOptions& options,
                        const FrameRecord& query,
                        const PictureLens& lens,
                        std::vector<FoundPlaces> of_parts) {
  FoundPlaces places = Join(options, std::move(of_parts));
  const bool few = places.num_matches < options.min_inliers;
  QueryResult result =
      FailedQuery(query, QueryVerdict::kNotInMap, few ? "too_few_matches" : "too_few_inliers");
  result.num_matches = places.num_matches;
  if (IsMirrored(options, places)) {
    result.reason = "mirrored";
  } else if (places.located) {
    Judge(options, lens, *std::move(places.located), std::move(places.rival), &result);
  }
  return result;
}

}  // namespace nightmap
