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

// Parts less alike than this share of the most alike one are searched only for pictures that the
// others did not locate. A rival has the share max_rival_ratio of a place's inliers, and a mirror
// image that wins the vote has more than the place: they have such a share of its words, too. In a
// building of rooms furnished alike all rivals were above 0.8, and parts without one had a median
// of 0.1, mirror images of 0.4.
constexpr double kMinLikeness = 0.5;
constexpr double kMinMirroredLikeness = 0.7;

// A picture, where to search for it, and what was found.
struct Search {
  struct Task {
    std::size_t part = 0;
    bool is_mirrored = false;  // searches for the mirror image
    bool is_likely = false;
    bool is_wanted = false;  // in this pass
  };

  DescribedPicture picture;
  std::string problem;
  std::optional<FrameFeatures> mirror_image;
  std::vector<Task> tasks;
  std::vector<FoundPlaces> found;  // by each task, in order

  bool IsLocated() const {
    return std::ranges::any_of(
        found, [](const FoundPlaces& by_task) { return by_task.located.has_value(); });
  }
  bool IsLocatedSurely(const LocalizeOptions& options) const {
    return std::ranges::any_of(found, [&](const FoundPlaces& by_task) {
      return by_task.located && IsInMap(options, *by_task.located);
    });
  }
};

void ChooseParts(const FrameRecord& query, const MapParts& parts, Search* begun) {
  Search& search = *begun;
  const FrameFeatures& features = search.picture.features;
  if (!search.picture.problem.empty() || features.NumFeatures() == 0) return;
  search.problem = FrameFailure(query.color.path, [&] {
    const auto alike = parts.MostAlike(features);
    const double best_score = alike.empty() ? 0 : alike[0].score;
    const double min_score = kMinLikeness * best_score;
    const double min_mirrored_score = kMinMirroredLikeness * best_score;
    for (const auto& [part, score] : alike) {
      search.tasks.push_back({part, false, score >= min_score});
    }
    search.mirror_image = MirrorFeatures(features, parts.Kind(), search.picture.lens.camera);
    if (search.mirror_image) {
      const auto mirrored = parts.MostAlike(*search.mirror_image);
      if (!mirrored.empty()) {
        const bool is_likely = mirrored[0].score >= min_mirrored_score;
        search.tasks.push_back({mirrored[0].part, true, is_likely});
      }
    }
    search.found.resize(search.tasks.size());
  });
}

// One pass over the parts in which pictures have tasks.
struct Pass {
  std::function<bool(const Search&, const Search::Task&)> wants;
  std::function<void(const Search::Task&, const Localizer&, const Picture&, FoundPlaces*)> run;
};

void RunTasks(const LocalizeOptions& options,
              const Pass& pass,
              std::size_t part,
              const Localizer& localizer,
              const FrameRecord& query,
              Search* search) {
  for (std::size_t i = 0; i < search->tasks.size(); ++i) {
    const Search::Task& task = search->tasks[i];
    if (!task.is_wanted || task.part != part) continue;
    const FrameFeatures& features =
        task.is_mirrored ? *search->mirror_image : search->picture.features;
    const Picture picture = MakePicture(options, query, search->picture.lens, features);
    pass.run(task, localizer, picture, &search->found[i]);
  }
}

// Loads each part once, those in memory first.
void Run(const LocalizeOptions& options,
         const Pass& pass,
         std::span<const FrameRecord> queries,
         int num_threads,
         MapParts& parts,
         std::vector<Search>* searches) {
  std::map<std::size_t, std::vector<std::size_t>> pictures_of_part;
  for (std::size_t i = 0; i < searches->size(); ++i) {
    Search& search = (*searches)[i];
    for (Search::Task& task : search.tasks) {
      task.is_wanted = pass.wants(search, task);
      if (!task.is_wanted) continue;
      std::vector<std::size_t>& pictures = pictures_of_part[task.part];
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
      search.problem = FrameFailure(
          query.color.path, [&] { RunTasks(options, pass, part, localizer, query, &search); });
    });
  }
}

// Active search for the picture and a rival, or for the mirror image.
void SearchPart(const Search::Task& task,
                const Localizer& localizer,
                const Picture& picture,
                FoundPlaces* found) {
  if (task.is_mirrored) {
    found->mirrored = localizer.SearchMirrored(picture);
  } else {
    *found = localizer.Search(picture);
    localizer.AddRival(picture, found);
  }
}

void RetrieveInPart(const Search::Task& /*task*/,
                    const Localizer& localizer,
                    const Picture& picture,
                    FoundPlaces* found) {
  localizer.Retrieve(picture, found);
  localizer.AddRival(picture, found);
}

// Active search in the likely parts; in the others for pictures that those did not locate; and
// retrieval for those that no part located.
std::vector<Pass> Passes(const LocalizeOptions& options) {
  const auto is_likely = [](const Search&, const Search::Task& task) { return task.is_likely; };
  const auto is_left = [&](const Search& search, const Search::Task& task) {
    return !task.is_likely && !search.IsLocatedSurely(options);
  };
  const auto is_not_located = [](const Search& search, const Search::Task& task) {
    return !task.is_mirrored && !search.IsLocated();
  };
  return {{is_likely, SearchPart}, {is_left, SearchPart}, {is_not_located, RetrieveInPart}};
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
    searches[i].picture = describe(queries[i]);
    progress.Advance();
  });
  begin_part("locate");
  ParallelFor(queries.size(), num_threads, [&](std::size_t i) {
    ChooseParts(queries[i], parts, &searches[i]);
  });
  for (const Pass& pass : Passes(options)) {
    Run(options, pass, queries, num_threads, parts, &searches);
  }
  std::vector<LocatedPicture> located(queries.size());
  ParallelFor(queries.size(), num_threads, [&](std::size_t i) {
    located[i] = Finish(options, queries[i], std::move(searches[i]));
    progress.Advance();
  });
  return located;
}

}  // namespace nightmap
