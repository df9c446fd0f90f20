// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/localizer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/base/random.h"
#include "stages/camera/localize/active_search.h"
#include "stages/camera/localize/mirror_features.h"
#include "stages/camera/localize/place_search.h"

namespace nightmap {
namespace {

constexpr int kMinSeedInliers = 8;  // smallest number of inliers of the first pose

}  // namespace

Picture MakePicture(const LocalizeOptions& options,
                    const FrameRecord& query,
                    const PictureLens& lens,
                    const FrameFeatures& features) {
  return {
      lens,
      features,
      Random(static_cast<std::uint64_t>(options.seed), static_cast<std::uint64_t>(query.frame_idx))
          .Next(),
      LensesToTry(lens)};
}

QueryResult Localizer::Localize(const FrameRecord& query,
                                const PictureLens& lens,
                                const FrameFeatures& features) const {
  if (features.NumFeatures() == 0) {
    return FailedQuery(query, QueryVerdict::kNoFeatures, "no_features");
  }
  const Picture picture = MakePicture(options_, query, lens, features);
  FoundPlaces places = Search(picture);
  Retrieve(picture, &places);
  const auto mirrored = MirrorFeatures(features, index_.Map().kind, lens.camera);
  if (mirrored) {
    places.mirrored = SearchMirrored(MakePicture(options_, query, lens, *mirrored));
  }
  if (!IsMirrored(options_, places)) AddRival(picture, &places);
  std::vector<FoundPlaces> of_parts;
  of_parts.push_back(std::move(places));
  return JudgePlaces(options_, query, lens, std::move(of_parts));
}

FoundPlaces Localizer::Search(const Picture& picture) const {
  FoundPlaces places;
  const auto first = SearchAndEstimate(picture, &places.num_matches);
  if (first) places.located = SearchAround(picture, *first);
  return places;
}

void Localizer::Retrieve(const Picture& picture, FoundPlaces* places) const {
  if (places->located) return;
  const auto first = SearchRetrieved(picture, &places->num_matches);
  if (first) places->located = SearchAround(picture, *first);
}

std::optional<Place> Localizer::SearchMirrored(const Picture& mirror_image) const {
  int num_matches = 0;
  const auto first = SearchAndEstimate(mirror_image, &num_matches);
  if (!first) return {};
  return SearchAround(mirror_image, *first);
}

void Localizer::AddRival(const Picture& picture, FoundPlaces* places) const {
  if (places->located) places->rival = SearchRival(picture, *places->located);
}

std::optional<Place> Localizer::SearchAndEstimate(const Picture& picture, int* num_matches) const {
  auto matches = ActiveSearch(options_, index_, picture.features).Run();
  *num_matches = static_cast<int>(matches.size());
  if (options_.covisibility_filter && !matches.empty()) matches = LargestPlace(index_, matches);
  return Estimate(picture, matches, kMinSeedInliers);
}

std::optional<Place> Localizer::SearchRetrieved(const Picture& picture, int* num_matches) const {
  std::optional<Place> best;
  if (options_.num_retrieved_keyframes == 0) return best;
  for (const auto& matches : SearchByRetrieval(options_, index_, picture.features)) {
    *num_matches = std::max(*num_matches, static_cast<int>(matches.size()));
    auto located = Estimate(picture, matches, kMinSeedInliers);
    if (located && (!best || located->NumInliers() > best->NumInliers())) best = std::move(located);
  }
  return best;
}

// Repeats the search around the first pose with a wider reach; keeps the pose with more support.
Place Localizer::SearchAround(const Picture& picture, const Place& first) const {
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

std::optional<Place> Localizer::SearchRival(const Picture& picture, const Place& located) const {
  if (options_.max_rival_ratio >= 1) return {};
  const auto matches = SearchRivals(options_, index_, picture.features, located.Inliers());
  // A rival that explains as much in the end matches more than a tenth of it here.
  const double num_enough = 0.1 * options_.max_rival_ratio * located.NumInliers();
  Picture same_lens = picture;
  same_lens.starts = {located.camera};
  const auto first =
      Estimate(same_lens, matches, std::max(kMinSeedInliers, static_cast<int>(num_enough)));
  if (!first) return {};
  Place rival = SearchAround(picture, *first);
  if (IsSameView(options_, located, rival)) return {};
  return rival;
}

std::optional<Place> Localizer::Estimate(const Picture& picture,
                                         const std::vector<LandmarkMatch>& matches,
                                         int min_inliers) const {
  std::vector<PointMatch> points;
  std::vector<float> sigmas_m;
  for (const LandmarkMatch& match : matches) {
    points.push_back(
        {picture.features.Feature(match.feature).Pixel(), index_.Position(match.landmark)});
    sigmas_m.push_back(index_.Map().position_sigmas_m[static_cast<std::size_t>(match.landmark)]);
  }
  auto found = EstimatePicturePose(
      options_, picture.lens, picture.starts, points, min_inliers, picture.random_seed);
  if (!found) return {};
  return Place{*std::move(found), matches, std::move(points), std::move(sigmas_m)};
}

}  // namespace nightmap
