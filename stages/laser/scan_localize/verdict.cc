// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/verdict.h"

#include <algorithm>
#include <cmath>

#include "stages/laser/scan_localize/object_evidence.h"

namespace nightmap {
namespace {

constexpr double kMinFit = 0.4;  // a place explains a scan from this fit on
// In the place of max_unique_ratio within a rough position, with the objects.
constexpr double kMaxUniqueRatioNearby = 0.88;
// So many walls of objects, of which so many are confirmed, are no chance.
constexpr int kMinObjectWalls = 20;
constexpr double kMinConfirmed = 0.7;
constexpr int kMinObjectLead = 10;
// Where most beams pass walls and few end on them, only a rough position speaks for a place.
constexpr double kMinChangedAgreement = -0.2;

// The largest of the others over the best; 0: there is no other.
double RivalRatio(const std::vector<ScanCandidate>& candidates, double ScanCandidate::*fit) {
  double second = 0;
  for (std::size_t i = 1; i < candidates.size(); ++i) second = std::max(second, candidates[i].*fit);
  return second / candidates.front().*fit;
}

// The share of the points that only the best place explains, less that of the other's own.
double LeadShare(const ScanCandidate& best, const ScanCandidate& other) {
  int lead = 0;
  for (std::size_t i = 0; i < best.on_wall.size(); ++i) lead += best.on_wall[i] - other.on_wall[i];
  return lead / std::max(1.0, static_cast<double>(best.on_wall.size()));
}

// Whether the objects, which cannot have changed, speak for one place and not for another.
bool DoObjectsDecide(const ObjectView& best, const ObjectView& other) {
  const int lead = best.num_confirmed - best.num_contradicted;
  return lead - (other.num_confirmed - other.num_contradicted) >= kMinObjectLead;
}

// Whether another place fits almost as well, or as well but for where walls lie in their cells,
// which changes the fit and not the points that are explained.
bool HasRival(const VerdictOptions& options,
              const std::vector<ScanCandidate>& candidates,
              bool are_objects_weighed) {
  const ScanCandidate& best = candidates.front();
  return std::any_of(candidates.begin() + 1, candidates.end(), [&](const ScanCandidate& other) {
    const double ratio = other.fit / best.fit;
    if (ratio > options.max_rival_ratio) return true;
    return ratio > options.max_unique_ratio && LeadShare(best, other) < options.min_lead_share &&
           (are_objects_weighed || !DoObjectsDecide(best.objects, other.objects));
  });
}

bool AreConfirmed(const ObjectView& objects) {
  const int num_seen = objects.num_confirmed + objects.num_contradicted;
  return num_seen >= kMinObjectWalls && objects.num_confirmed >= kMinConfirmed * num_seen;
}

bool IsInMap(const VerdictOptions& options,
             const ScanQuery& query,
             const std::vector<ScanCandidate>& candidates) {
  const ScanCandidate& best = candidates.front();
  const double agreement = best.score - best.through_share;
  if (agreement >= options.min_agreement) return true;
  if (query.rough_position) {
    return AreConfirmed(best.objects) ||
           RivalRatio(candidates, &ScanCandidate::fit) <= kMaxUniqueRatioNearby;
  }
  return agreement >= kMinChangedAgreement &&
         RivalRatio(candidates, &ScanCandidate::walls_fit) <= options.max_unique_ratio;
}

double PositionSigma_m(const ScanCandidate& candidate) {
  return std::sqrt(candidate.covariance(0, 0) + candidate.covariance(1, 1));
}

}  // namespace

ScanVerdict Judge(const VerdictOptions& options,
                  const ScanQuery& query,
                  std::size_t num_points,
                  const std::vector<ScanCandidate>& candidates,
                  bool are_objects_weighed) {
  if (num_points < static_cast<std::size_t>(options.min_points)) {
    return {QueryVerdict::kNoFeatures, "too_few_points"};
  }
  if (candidates.empty() || candidates.front().fit < kMinFit) {
    return {QueryVerdict::kNotInMap, "poor_fit"};
  }
  const bool is_refused = are_objects_weighed && SpeakAgainst(candidates.front().objects);
  if (is_refused || !IsInMap(options, query, candidates)) {
    return {QueryVerdict::kNotInMap, "not_alike"};
  }
  if (HasRival(options, candidates, are_objects_weighed)) {
    return {QueryVerdict::kAmbiguous, "rival_place"};
  }
  if (PositionSigma_m(candidates.front()) > options.max_position_sigma_m) {
    return {QueryVerdict::kAmbiguous, "uncertain_pose"};
  }
  return {QueryVerdict::kLocated, ""};
}

}  // namespace nightmap
