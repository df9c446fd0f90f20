// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/loops/loops.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <limits>

#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/camera/inverted_file.h"
#include "stages/camera/loops/same_node_matcher.h"

namespace nightmap {
namespace {

constexpr int kNumCandidates = 4;  // candidates verified per frame
// Smallest number of inliers among features that share a word, before all features are compared.
constexpr int kMinQuickInliers = 10;
constexpr int kQuickIterations = 150;  // enough where a third of the matches are correct
constexpr int kNodeLevel = 2;          // a hundred nodes at the default branching

using Ranking = std::vector<InvertedFile::Result>;

// Accepts pairs in which min_quick_inliers features of common nodes agree.
QuickCheck MakeQuickCheck(const LoopsOptions& options, const SameNodeMatcher& matcher) {
  VerifyOptions quick = options.verify;
  quick.pose.min_inliers = kMinQuickInliers;
  quick.pose.max_iterations = std::min(kQuickIterations, quick.pose.max_iterations);
  quick.min_spread = 0;
  quick.max_sigma_m = std::numeric_limits<double>::infinity();
  return {quick, [&](const FrameFeatures& a, const FrameFeatures& b) {
            return matcher.Match(a, b, options.verify.max_ratio);
          }};
}

// Loops look up a frame's words by its index.
void CheckVocabulary(const FramesWithFeatures& input, const Vocabulary& vocabulary) {
  if (vocabulary.tree.Kind() == input.features.Heads().kind &&
      vocabulary.words.size() == input.frames.size() && input.frames.front().frame_idx == 0) {
    return;
  }
  throw InputError({{"vocabulary"}},
                   "lists {} frames, the features {} from frame {} on, or of another kind",
                   vocabulary.words.size(),
                   input.frames.size(),
                   input.frames.front().frame_idx);
}

// Greedy choice of the best-scored candidates that are not neighbours of one chosen already.
Ranking Thin(const Ranking& ranked, int count, int min_distance) {
  Ranking chosen;
  for (const InvertedFile::Result& candidate : ranked) {
    if (static_cast<int>(chosen.size()) == count) break;
    const bool is_near = std::ranges::any_of(chosen, [&](const InvertedFile::Result& other) {
      return std::abs(other.frame_idx - candidate.frame_idx) < min_distance;
    });
    if (!is_near) chosen.push_back(candidate);
  }
  return chosen;
}

// Frames that search for loops.
std::vector<int> LoopSeekers(const LoopsOptions& options,
                             const std::vector<FrameFeatures>& frames) {
  std::vector<int> seekers;
  int num_described = 0;
  for (const FrameFeatures& frame : frames) {
    if (frame.IsDescribed() && num_described++ % options.stride == 0) {
      seekers.push_back(frame.frame_idx);
    }
  }
  return seekers;
}

bool Finds(const Ranking& ranking, int frame_idx, int max_distance) {
  return std::ranges::any_of(ranking, [&](const InvertedFile::Result& result) {
    return std::abs(result.frame_idx - frame_idx) <= max_distance;
  });
}

// For each seeker the most similar frames, best first.
std::vector<Ranking> RankAlike(const LoopsOptions& options,
                               const std::vector<std::vector<int>>& words,
                               const std::vector<int>& seekers,
                               int num_threads) {
  const InvertedFile inverted_file(words);
  std::vector<Ranking> rankings(seekers.size());
  ParallelFor(seekers.size(), num_threads, [&](std::size_t k) {
    const int before = seekers[k] - options.min_gap + 1;
    if (before <= 0) return;
    rankings[k] = inverted_file.Query(
        words[static_cast<std::size_t>(seekers[k])], 8 * kNumCandidates, before);
  });
  return rankings;
}

// Candidates, split by whether the seekers beside b also find the place of a.
struct Candidates {
  std::vector<FramePair> consistent;
  std::vector<FramePair> inconsistent;
};

Candidates ChooseCandidates(const LoopsOptions& options,
                            const std::vector<int>& seekers,
                            const std::vector<Ranking>& rankings) {
  Candidates chosen;
  const int min_distance = options.min_gap / 2;
  for (std::size_t k = 0; k < seekers.size(); ++k) {
    for (const auto& candidate : Thin(rankings[k], kNumCandidates, min_distance)) {
      FramePair pair = MakePair(candidate.frame_idx, seekers[k]);
      pair.score = candidate.score;
      const bool is_found_beside =
          (k > 0 && Finds(rankings[k - 1], candidate.frame_idx, min_distance)) ||
          (k + 1 < seekers.size() && Finds(rankings[k + 1], candidate.frame_idx, min_distance));
      pair.status = PairStatus::kInconsistent;
      (is_found_beside ? chosen.consistent : chosen.inconsistent).push_back(pair);
    }
  }
  return chosen;
}

}  // namespace

std::vector<FramePair> RunLoops(const LoopsOptions& options,
                                const FramesWithFeatures& input,
                                const Vocabulary& vocabulary,
                                Progress& progress,
                                int num_threads) {
  const FeaturesShard& heads = input.features.Heads();
  CheckFeaturesOfFrames(input.frames, heads);
  CheckVocabulary(input, vocabulary);
  const std::vector<int> seekers = LoopSeekers(options, heads.frames);
  const auto rankings = RankAlike(options, vocabulary.words, seekers, num_threads);
  auto [pairs, inconsistent] = ChooseCandidates(options, seekers, rankings);
  const SameNodeMatcher matcher(vocabulary, kNodeLevel);
  const QuickCheck quick = MakeQuickCheck(options, matcher);
  VerifyPairs(options.verify, &quick, input, num_threads, progress, &pairs);
  std::ranges::move(inconsistent, std::back_inserter(pairs));
  SortPairs(&pairs);
  return pairs;
}

}  // namespace nightmap
