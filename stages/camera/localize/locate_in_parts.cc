// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/locate_in_parts.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"
#include "stages/camera/localize/mirror_features.h"

namespace nightmap {
namespace {

// A picture, where to search for it, and what was found.
struct Search {
  DescribedPicture picture;
  std::string problem;
  std::optional<FrameFeatures> mirror_image;
  std::vector<std::size_t> parts;
  std::optional<std::size_t> mirror_part;
  std::vector<FoundPlaces> found;  // in each part, in order; the last: of the mirror image

  bool IsLocated() const {
    return std::ranges::any_of(
        found, [](const FoundPlaces& in_part) { return in_part.located.has_value(); });
  }
};

Search Begin(const FrameRecord& query, DescribedPicture picture, const MapParts& parts) {
  Search search{std::move(picture), {}, {}, {}, {}, {}};
  const FrameFeatures& features = search.picture.features;
  if (!search.picture.problem.empty() || features.NumFeatures() == 0) return search;
  search.problem = FrameFailure(query.color.path, [&] {
    search.parts = parts.MostAlike(features);
    search.mirror_image = MirrorFeatures(features, parts.Kind(), search.picture.lens.camera);
    if (search.mirror_image) {
      const auto alike = parts.MostAlike(*search.mirror_image);
      if (!alike.empty()) search.mirror_part = alike[0];
    }
    search.found.resize(search.parts.size() + 1);
  });
  return search;
}

// One pass over the parts that pictures want.
struct Pass {
  // The parts in which a picture is searched.
  std::function<std::vector<std::size_t>(const Search&)> wanted;
  // Searches a picture in one of them.
  std::function<void(std::size_t part, const Localizer&, const FrameRecord&, Search*)> search;
};

// Loads each part once, those in memory first.
void Run(const Pass& pass,
         std::span<const FrameRecord> queries,
         int num_threads,
         MapParts& parts,
         std::vector<Search>* searches) {
  std::map<std::size_t, std::vector<std::size_t>> pictures_of_part;
  for (std::size_t i = 0; i < searches->size(); ++i) {
    for (const std::size_t part : pass.wanted((*searches)[i])) {
      std::vector<std::size_t>& pictures = pictures_of_part[part];
      if (pictures.empty() || pictures.back() != i) pictures.push_back(i);
    }
  }
  std::vector<std::size_t> order;
  for (const auto& [part, pictures] : pictures_of_part) order.push_back(part);
  std::stable_partition(
      order.begin(), order.end(), [&](std::size_t part) { return parts.IsLoaded(part); });
  for (const std::size_t part : order) {
    const std::vector<std::size_t>& pictures = pictures_of_part[part];
    const Localizer& localizer = parts.Load(part);
    ParallelFor(pictures.size(), num_threads, [&](std::size_t k) {
      Search& search = (*searches)[pictures[k]];
      const FrameRecord& query = queries[pictures[k]];
      if (!search.problem.empty()) return;
      search.problem =
          FrameFailure(query.color.path, [&] { pass.search(part, localizer, query, &search); });
    });
  }
}

// Active search for the picture, a rival, and the mirror image.
Pass FirstPass(const LocalizeOptions& options) {
  const auto wanted = [](const Search& search) {
    std::vector<std::size_t> parts = search.parts;
    if (search.mirror_part) parts.push_back(*search.mirror_part);
    return parts;
  };
  const auto search_part =
      [&](std::size_t part, const Localizer& localizer, const FrameRecord& query, Search* search) {
        const PictureLens& lens = search->picture.lens;
        const Picture picture = MakePicture(options, query, lens, search->picture.features);
        for (std::size_t i = 0; i < search->parts.size(); ++i) {
          if (search->parts[i] != part) continue;
          search->found[i] = localizer.Search(picture);
          localizer.AddRival(picture, &search->found[i]);
        }
        if (search->mirror_part == part) {
          search->found.back().mirrored =
              localizer.SearchMirrored(MakePicture(options, query, lens, *search->mirror_image));
        }
      };
  return {wanted, search_part};
}

// Retrieval for the pictures that no part located.
Pass SecondPass(const LocalizeOptions& options) {
  const auto wanted = [](const Search& search) {
    return search.IsLocated() ? std::vector<std::size_t>() : search.parts;
  };
  const auto search_part =
      [&](std::size_t part, const Localizer& localizer, const FrameRecord& query, Search* search) {
        const Picture picture =
            MakePicture(options, query, search->picture.lens, search->picture.features);
        for (std::size_t i = 0; i < search->parts.size(); ++i) {
          if (search->parts[i] != part) continue;
          localizer.Retrieve(picture, &search->found[i]);
          localizer.AddRival(picture, &search->found[i]);
        }
      };
  return {wanted, search_part};
}

LocatedPicture Finish(const LocalizeOptions& options, const FrameRecord& query, Search search) {
  const DescribedPicture& picture = search.picture;
  if (!picture.problem.empty()) return UnusedPicture(query, picture.problem, false);
  if (picture.features.NumFeatures() == 0) {
    return {FailedQuery(query, QueryVerdict::kNoFeatures, "no_features"), ""};
  }
  LocatedPicture located;
  if (search.problem.empty()) {
    search.problem = FrameFailure(query.color.path, [&] {
      located.result = JudgePlaces(options, query, picture.lens, std::move(search.found));
    });
  }
  return search.problem.empty() ? located : UnusedPicture(query, search.problem, true);
}

}  // namespace

LocatedPicture UnusedPicture(const FrameRecord& query,
                             const std::string& problem,
                             bool is_described) {
  const char* reason = is_described ? "search_failed" : "unreadable_image";
  return {FailedQuery(query, QueryVerdict::kUnreadable, reason), problem};
}

std::vector<LocatedPicture> LocateInParts(
    const LocalizeOptions& options,
    std::span<const FrameRecord> queries,
    const std::function<DescribedPicture(const FrameRecord&)>& describe,
    const std::function<void(const char*)>& begin_part,
    MapParts& parts,
    Progress& progress,
    int num_threads) {
  std::vector<Search> searches(queries.size());
  begin_part("extract");
  ParallelFor(queries.size(), num_threads, [&](std::size_t i) {
    searches[i] = Begin(queries[i], describe(queries[i]), parts);
    progress.Advance();
  });
  begin_part("locate");
  Run(FirstPass(options), queries, num_threads, parts, &searches);
  Run(SecondPass(options), queries, num_threads, parts, &searches);
  std::vector<LocatedPicture> located(queries.size());
  ParallelFor(queries.size(), num_threads, [&](std::size_t i) {
    located[i] = Finish(options, queries[i], std::move(searches[i]));
    progress.Advance();
  });
  return located;
}

}  // namespace nightmap
