// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/localize.h"

#include <algorithm>
#include <future>
#include <span>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"
#include "stages/camera/localize/describe_picture.h"
#include "stages/camera/localize/localizer.h"

namespace nightmap {
namespace {

void CheckInput(const LocalizeInput& input) {
  const LandmarkMap& map = *input.map;
  const VocabularyTree& tree = input.vocabulary->tree;
  if (input.queries.empty()) {
    throw DataError(
        "queries: no queries to localize; set hold_out_every or add a [[query]] to the site");
  }
  if (map.NumLandmarks() == 0) throw InputError({{"landmarks"}}, "the map is empty");
  const auto max_word = std::max_element(map.words.begin(), map.words.end());
  if (tree.Kind() != map.kind || input.extraction.Kind() != map.kind ||
      tree.Depth() != map.num_word_levels || *max_word >= tree.NumNodes()) {
    throw InputError({{"landmarks"}, {"vocabulary"}}, "made with another vocabulary");
  }
  for (const FrameRecord& query : input.queries) {
    if (query.camera_idx < 0 || query.camera_idx >= static_cast<int>(input.cameras.size())) {
      throw DataError(
          "queries: query {} has camera_idx {} out of range", query.frame_idx, query.camera_idx);
    }
  }
}

struct LocatedPicture {
  QueryResult result;
  std::string problem;  // why the picture could not be used
};

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
    LocatedPicture& found = located[i];
    found.problem = picture.problem;
    if (found.problem.empty()) {
      found.problem = FrameFailure(queries[i].color.path, [&] {
        found.result = localizer.Localize(queries[i], picture.lens, picture.features);
      });
    }
    if (found.problem.empty()) return;
    const char* reason = picture.problem.empty() ? "search_failed" : "unreadable_image";
    found.result = FailedQuery(queries[i], QueryVerdict::kUnreadable, reason);
  };
  input.begin_part("extract");
  ParallelFor(2 * queries.size(), num_threads, [&](std::size_t i) {
    if (i == queries.size()) input.begin_part("locate");
    i < queries.size() ? describe[i]() : locate(i - queries.size());
    progress.Advance();
  });
  return located;
}

}  // namespace

std::vector<QueryResult> RunLocalize(const LocalizeOptions& options,
                                     const LocalizeInput& input,
                                     Progress& progress,
                                     int num_threads) {
  constexpr std::size_t kBatch = 256;  // bounds the memory for features
  CheckInput(input);
  const Localizer localizer(options, *input.map, *input.vocabulary);
  std::vector<QueryResult> results;
  progress.Start(2 * input.queries.size());
  for (std::size_t begin = 0; begin < input.queries.size(); begin += kBatch) {
    const std::size_t count = std::min(kBatch, input.queries.size() - begin);
    const std::span queries(&input.queries[begin], count);
    for (LocatedPicture& located :
         LocateBatch(options, input, localizer, queries, progress, num_threads)) {
      if (!located.problem.empty()) input.skip(located.problem);
      results.push_back(std::move(located.result));
    }
  }
  progress.Finish();
  return results;
}

}  // namespace nightmap
