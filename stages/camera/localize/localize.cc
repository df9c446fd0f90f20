// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/localize.h"

#include <algorithm>
#include <functional>
#include <future>
#include <numeric>
#include <span>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"
#include "stages/camera/localize/describe_picture.h"
#include "stages/camera/localize/localizer.h"
#include "stages/camera/localize/locate_in_parts.h"

namespace nightmap {
namespace {

std::int64_t NumLandmarks(const MapInRegions& map) {
  std::int64_t sum = 0;
  for (const LandmarkRegion& region : map.regions) sum += region.num_landmarks;
  return sum;
}

void CheckInput(const LocalizeInput& input) {
  const LandmarkMap& head = input.map->head;
  const VocabularyTree& tree = input.vocabulary->tree;
  if (input.queries.empty()) {
    throw DataError(
        "queries: no queries to localize; set hold_out_every or add a [[query]] to the site");
  }
  if (NumLandmarks(*input.map) == 0) throw InputError({{"landmarks"}}, "the map is empty");
  if (tree.Kind() != head.kind || input.extraction.Kind() != head.kind ||
      tree.Depth() != head.num_word_levels) {
    throw InputError({{"landmarks"}, {"vocabulary"}}, "made with another vocabulary");
  }
  for (const FrameRecord& query : input.queries) {
    if (query.camera_idx < 0 || query.camera_idx >= static_cast<int>(input.cameras.size())) {
      throw DataError(
          "queries: query {} has camera_idx {} out of range", query.frame_idx, query.camera_idx);
    }
  }
}

// Describes all pictures, then locates all, in one loop: a thread with no picture left to describe
// goes on to locate, so none waits for the slowest picture.
std::vector<LocatedPicture> LocateBatch(const LocalizeOptions& options,
                                        const LocalizeInput& input,
                                        const Localizer& localizer,
                                        std::span<const FrameRecord> queries,
                                        Progress& progress,
                                        int num_threads) {
  std::vector<std::packaged_task<DescribedPicture()>> describe;
  std::vector<std::future<DescribedPicture>> described;
  for (const FrameRecord& query : queries) {
    describe.emplace_back([&] { return DescribePicture(options, input, query); });
    described.push_back(describe.back().get_future());
  }
  std::vector<LocatedPicture> located(queries.size());
  const auto locate = [&](std::size_t i) {
    const DescribedPicture picture = described[i].get();
    std::string problem = picture.problem;
    if (problem.empty()) {
      problem = FrameFailure(queries[i].color.path, [&] {
        located[i].result = localizer.Localize(queries[i], picture.lens, picture.features);
      });
    }
    if (problem.empty()) return;
    located[i] = UnusedPicture(queries[i], problem, picture.problem.empty());
  };
  input.begin_part("extract");
  ParallelFor(2 * queries.size(), num_threads, [&](std::size_t i) {
    if (i == queries.size()) input.begin_part("locate");
    i < queries.size() ? describe[i]() : locate(i - queries.size());
    progress.Advance();
  });
  return located;
}

// Pictures at a time: bounds the memory for features. In parts as many as that takes little beside
// the map, since each batch may load all parts.
constexpr std::size_t kBatch = 256;
constexpr std::size_t kBatchInParts = 1024;

using LocateQueries =
    std::function<std::vector<LocatedPicture>(std::span<const FrameRecord> queries)>;

std::vector<QueryResult> LocateAll(const LocalizeInput& input,
                                   const LocateQueries& locate,
                                   std::size_t max_batch,
                                   Progress& progress) {
  std::vector<QueryResult> results;
  progress.Start(2 * input.queries.size());
  for (std::size_t begin = 0; begin < input.queries.size(); begin += max_batch) {
    const std::size_t count = std::min(max_batch, input.queries.size() - begin);
    for (LocatedPicture& located : locate(std::span(&input.queries[begin], count))) {
      if (!located.problem.empty()) input.skip(located.problem);
      results.push_back(std::move(located.result));
    }
  }
  progress.Finish();
  return results;
}

}  // namespace

std::vector<QueryResult> RunLocalize(const LocalizeOptions& options,
                                     const LocalizeInput& input,
                                     Progress& progress,
                                     int num_threads) {
  CheckInput(input);
  const VocabularyIndex& vocabulary = *input.vocabulary;
  if (NumLandmarks(*input.map) > input.limits.whole_landmarks) {
    MapParts parts(options, *input.map, vocabulary, input.limits);
    const auto locate = [&](std::span<const FrameRecord> queries) {
      const auto describe = [&](const FrameRecord& query) {
        return DescribePicture(options, input, query);
      };
      return LocateInParts(
          options, queries, describe, input.begin_part, parts, progress, num_threads);
    };
    return LocateAll(input, locate, kBatchInParts, progress);
  }
  std::vector<std::size_t> regions(input.map->regions.size());
  std::iota(regions.begin(), regions.end(), std::size_t{0});
  const LandmarkMap map = ReadRegions(*input.map, regions, vocabulary.tree);
  const Localizer localizer(options, map, vocabulary);
  const auto locate = [&](std::span<const FrameRecord> queries) {
    return LocateBatch(options, input, localizer, queries, progress, num_threads);
  };
  return LocateAll(input, locate, kBatch, progress);
}

}  // namespace nightmap
