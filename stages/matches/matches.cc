// SPDX-License-Identifier: Apache-2.0
#include "stages/matches/matches.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/features_of_frames.h"
#include "stages/matches/direct_index.h"
#include "stages/matches/neighbour_pairs.h"
#include "stages/matches/verify_pair.h"

namespace nightmap {
namespace {

constexpr int kQuickIterations = 150;  // enough where a third of the matches are right
constexpr int kIndexLevel = 2;         // a hundred nodes at the default branching

using Ranking = std::vector<InvertedFile::Result>;

VerifyOptions MakeVerifyOptions(const MatchesOptions& options, DescriptorKind kind, bool is_loop) {
  VerifyOptions verify;
  verify.kind = kind;
  verify.max_ratio = options.max_ratio;
  verify.min_spread = is_loop ? options.loop_min_spread : options.min_spread;
  if (is_loop) verify.max_sigma_m = options.loop_max_sigma_m;
  verify.pose.max_error_px = options.max_error_px;
  verify.pose.max_depth_error = options.max_depth_error;
  verify.pose.min_inliers = is_loop ? options.loop_min_inliers : options.min_inliers;
  verify.pose.max_iterations = options.max_ransac_iterations;
  return verify;
}

// One random stream a pair, whatever the order of work.
std::uint64_t PairSeed(int seed, const FramePair& pair) {
  return (static_cast<std::uint64_t>(seed) << 48) ^
         (static_cast<std::uint64_t>(pair.frame_a) << 24) ^
         static_cast<std::uint64_t>(pair.frame_b);
}

// Verifies pairs in parallel; the same whatever the number of threads.
class Verifier {
 public:
  Verifier(const MatchesOptions& options, const MatchesInput& input, bool is_loop)
      : options_(options),
        input_(input),
        verify_(MakeVerifyOptions(options, input.features.kind, is_loop)) {}

  // Loops: pairs that few features of a common node agree on are rejected before all features are
  // compared.
  void UseIndex(const DirectIndex* index) { index_ = index; }

  void Run(int num_threads, Progress& progress, std::vector<FramePair>* pairs) const {
    progress.Start(pairs->size());
    ParallelFor(pairs->size(), num_threads, [&](std::size_t i) {
      Verify(&(*pairs)[i]);
      progress.Advance();
    });
  }

 private:
  std::size_t At(int frame_idx) const {
    return static_cast<std::size_t>(frame_idx - input_.frames.front().frame_idx);
  }
  const RgbdCamera& CameraOf(int frame_idx) const {
    return input_.cameras.at(static_cast<std::size_t>(input_.frames[At(frame_idx)].camera_idx));
  }

  void Verify(FramePair* pair) const {
    const FrameFeatures& a = input_.features.frames[At(pair->frame_a)];
    const FrameFeatures& b = input_.features.frames[At(pair->frame_b)];
    const RgbdCamera& camera_a = CameraOf(pair->frame_a);
    const RgbdCamera& camera_b = CameraOf(pair->frame_b);
    VerifyOptions own = verify_;
    own.pose.seed = PairSeed(options_.seed, *pair);
    if (index_) {
      VerifyOptions quick = own;
      quick.pose.min_inliers = options_.loop_min_quick_inliers;
      quick.pose.max_iterations = std::min(kQuickIterations, options_.max_ransac_iterations);
      quick.min_spread = 0;
      quick.max_sigma_m = std::numeric_limits<double>::infinity();
      const auto shared = index_->Match(pair->frame_a, pair->frame_b, options_.max_ratio);
      VerifyMatches(quick, shared, a, camera_a, b, camera_b, pair);
      if (pair->status != PairStatus::kAccepted) return;
    }
    VerifyPair(own, a, camera_a, b, camera_b, pair);
  }

  const MatchesOptions& options_;
  const MatchesInput& input_;
  VerifyOptions verify_;
  const DirectIndex* index_ = nullptr;
};

// Loops are found by the place of a frame in the vocabulary, and their features by their words'.
void CheckVocabulary(const MatchesInput& input, const Vocabulary& vocabulary) {
  const auto& words = vocabulary.inverted_file.Words();
  bool fits = vocabulary.tree.Kind() == input.features.kind &&
              words.size() == input.frames.size() && input.frames.front().frame_idx == 0;
  for (std::size_t i = 0; fits && i < words.size(); ++i) {
    const FrameFeatures& frame = input.features.frames[i];
    const int num_described = frame.IsDescribed() ? frame.NumFeatures() : 0;
    fits = words[i].size() <= static_cast<std::size_t>(num_described);
  }
  if (fits) return;
  throw DataError(
      "the vocabulary lists {} frames, the features {} from frame {} on, or the words of one are "
      "not those of its features; delete the vocabulary folder of this site and run make",
      words.size(),
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

// Frames that look for loops.
std::vector<int> LoopSeekers(const MatchesOptions& options, const FeaturesShard& features) {
  std::vector<int> seekers;
  int num_described = 0;
  for (const FrameFeatures& frame : features.frames) {
    if (frame.IsDescribed() && num_described++ % options.loop_stride == 0) {
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

}  // namespace

void MatchesOptions::Register(OptionList& list) {
  list.Add("max_ratio", &max_ratio, Range(0.3, 1.0), "Lowe's ratio of nearest to second nearest");
  list.Add("pair_offsets",
           &pair_offsets,
           Range(1, 100),
           "each described frame is matched to the described frames this many before it");
  list.Add("wide_search",
           &wide_search,
           Range(0, 1000),
           "a described frame that matches none of these is matched to so many before it");
  list.Add("max_error_px", &max_error_px, Range(0.5, 20), "inlier threshold on reprojection");
  list.Add("max_depth_error",
           &max_depth_error,
           Range(0.005, 1),
           "inlier threshold on measured depth, relative");
  list.Add("min_inliers", &min_inliers, Range(4, 1000), "of a pair of neighbours");
  list.Add(
      "min_spread", &min_spread, Range(0, 1), "share of the image a pair's inliers must cover");
  list.Add(
      "loop_stride", &loop_stride, Range(1, 1000), "every Nth described frame looks for loops");
  list.Add("loop_num_candidates",
           &loop_num_candidates,
           Range(0, 100),
           "candidates verified per frame; 0: no loops");
  list.Add("loop_min_gap", &loop_min_gap, Range(1, 100000), "frames between the ends of a loop");
  list.Add("loop_min_inliers", &loop_min_inliers, Range(4, 1000), "of a loop");
  list.Add(
      "loop_min_quick_inliers",
      &loop_min_quick_inliers,
      Range(0, 1000),
      "of a loop among features that share a word; fewer: not all are compared; 0: always all");
  list.Add("loop_min_spread",
           &loop_min_spread,
           Range(0, 1),
           "share of the image a loop's inliers must cover");
  list.Add("loop_max_sigma_m",
           &loop_max_sigma_m,
           Range(0.0001, 100),
           "standard deviation of a loop's translation in its worst direction");
  list.Add("max_ransac_iterations", &max_ransac_iterations, Range(10, 100000), "of one pair");
  list.Add("seed", &seed, Range(0, 1e6), "of RANSAC");
}

std::vector<FramePair> MatchNeighbours(const MatchesOptions& options,
                                       const MatchesInput& input,
                                       int first_frame_idx,
                                       int num_threads,
                                       Progress& progress) {
  CheckFeaturesOfFrames(input.frames, input.features);
  const NeighbourPairs neighbours(input.features, first_frame_idx);
  std::vector<FramePair> pairs = neighbours.AtOffsets(options.pair_offsets);
  const Verifier verifier(options, input, /*is_loop=*/false);
  verifier.Run(num_threads, progress, &pairs);
  std::vector<FramePair> wide = neighbours.Wide(pairs, options.wide_search);
  verifier.Run(num_threads, progress, &wide);
  std::ranges::move(wide, std::back_inserter(pairs));
  SortPairs(&pairs);
  return pairs;
}

std::vector<FramePair> MatchLoops(const MatchesOptions& options,
                                  const MatchesInput& input,
                                  const Vocabulary& vocabulary,
                                  int num_threads,
                                  Progress& progress) {
  CheckFeaturesOfFrames(input.frames, input.features);
  CheckVocabulary(input, vocabulary);
  const auto& words = vocabulary.inverted_file.Words();
  const std::vector<int> seekers = LoopSeekers(options, input.features);
  std::vector<Ranking> rankings(seekers.size());
  ParallelFor(seekers.size(), num_threads, [&](std::size_t k) {
    const int before = seekers[k] - options.loop_min_gap + 1;
    if (before <= 0 || options.loop_num_candidates == 0) return;
    rankings[k] = vocabulary.inverted_file.Query(
        words[static_cast<std::size_t>(seekers[k])], 8 * options.loop_num_candidates, before);
  });
  std::vector<FramePair> consistent;
  std::vector<FramePair> pairs;
  for (std::size_t k = 0; k < seekers.size(); ++k) {
    const int min_distance = options.loop_min_gap / 2;
    for (const auto& candidate : Thin(rankings[k], options.loop_num_candidates, min_distance)) {
      FramePair pair = MakePair(candidate.frame_idx, seekers[k]);
      pair.score = candidate.score;
      const bool is_found_beside =
          (k > 0 && Finds(rankings[k - 1], candidate.frame_idx, min_distance)) ||
          (k + 1 < seekers.size() && Finds(rankings[k + 1], candidate.frame_idx, min_distance));
      pair.status = PairStatus::kInconsistent;
      (is_found_beside ? consistent : pairs).push_back(pair);
    }
  }
  Verifier verifier(options, input, /*is_loop=*/true);
  const DirectIndex index(vocabulary, input.features, kIndexLevel);
  if (options.loop_min_quick_inliers > 0) verifier.UseIndex(&index);
  verifier.Run(num_threads, progress, &consistent);
  std::ranges::move(consistent, std::back_inserter(pairs));
  SortPairs(&pairs);
  return pairs;
}

}  // namespace nightmap
