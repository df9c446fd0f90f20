// SPDX-License-Identifier: Apache-2.0
#include "stages/matches/matches.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "stages/matches/verify_pair.h"

namespace nightmap {
namespace {

VerifyOptions MakeVerifyOptions(const MatchesOptions& options, DescriptorKind kind, bool is_loop) {
  VerifyOptions verify;
  verify.kind = kind;
  verify.max_ratio = options.max_ratio;
  verify.min_spread = is_loop ? options.loop_min_spread : options.min_spread;
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

void VerifyAll(const MatchesOptions& options,
               const MatchesInput& input,
               bool is_loop,
               int num_threads,
               Progress& progress,
               std::vector<FramePair>* pairs) {
  const int first_idx = input.frames.front().frame_idx;
  const VerifyOptions verify = MakeVerifyOptions(options, input.features.kind, is_loop);
  const auto at = [&](int frame_idx) { return static_cast<std::size_t>(frame_idx - first_idx); };
  const auto camera_of = [&](int frame_idx) -> const RgbdCamera& {
    return input.cameras.at(static_cast<std::size_t>(input.frames[at(frame_idx)].camera_idx));
  };
  progress.Start(pairs->size());
  ParallelFor(pairs->size(), num_threads, [&](std::size_t i) {
    FramePair& pair = (*pairs)[i];
    VerifyOptions own = verify;
    own.pose.seed = PairSeed(options.seed, pair);
    VerifyPair(own,
               input.features.frames[at(pair.frame_a)],
               camera_of(pair.frame_a),
               input.features.frames[at(pair.frame_b)],
               camera_of(pair.frame_b),
               &pair);
    progress.Advance();
  });
}

void CheckInput(const MatchesInput& input) {
  const auto& frames = input.frames;
  bool fits = !frames.empty() && frames.size() == input.features.frames.size();
  for (std::size_t i = 0; fits && i < frames.size(); ++i) {
    fits = frames[i].frame_idx == input.features.frames[i].frame_idx &&
           frames[i].frame_idx == frames.front().frame_idx + static_cast<int>(i);
  }
  if (!fits) {
    throw DataError(
        "the features are not of the listed frames; delete the features folder of this "
        "site and run make");
  }
}

// Greedy choice of the best-scored candidates that are not neighbours of one chosen already.
std::vector<InvertedFile::Result> Thin(const std::vector<InvertedFile::Result>& ranked,
                                       int count,
                                       int min_distance) {
  std::vector<InvertedFile::Result> chosen;
  for (const InvertedFile::Result& candidate : ranked) {
    if (static_cast<int>(chosen.size()) == count) break;
    const bool is_near = std::ranges::any_of(chosen, [&](const InvertedFile::Result& other) {
      return std::abs(other.frame_idx - candidate.frame_idx) < min_distance;
    });
    if (!is_near) chosen.push_back(candidate);
  }
  return chosen;
}

}  // namespace

void MatchesOptions::Register(OptionList& list) {
  list.Add("max_ratio", &max_ratio, Range(0.3, 1.0), "Lowe's ratio of nearest to second nearest");
  list.Add("pair_offsets",
           &pair_offsets,
           Range(1, 100),
           "each frame is matched to the frames this many before it");
  list.Add("max_error_px", &max_error_px, Range(0.5, 20), "inlier threshold on reprojection");
  list.Add("max_depth_error",
           &max_depth_error,
           Range(0.005, 1),
           "inlier threshold on measured depth, relative");
  list.Add("min_inliers", &min_inliers, Range(4, 1000), "of a pair of neighbours");
  list.Add(
      "min_spread", &min_spread, Range(0, 1), "share of the image a pair's inliers must cover");
  list.Add("loop_stride", &loop_stride, Range(1, 1000), "every Nth frame looks for loops");
  list.Add("loop_num_candidates",
           &loop_num_candidates,
           Range(0, 100),
           "candidates verified per frame; 0: no loops");
  list.Add("loop_min_gap", &loop_min_gap, Range(1, 100000), "frames between the ends of a loop");
  list.Add("loop_min_inliers", &loop_min_inliers, Range(4, 1000), "of a loop");
  list.Add("loop_min_spread",
           &loop_min_spread,
           Range(0, 1),
           "share of the image a loop's inliers must cover");
  list.Add("max_ransac_iterations", &max_ransac_iterations, Range(10, 100000), "of one pair");
  list.Add("seed", &seed, Range(0, 1e6), "of RANSAC");
}

std::vector<FramePair> MatchNeighbours(const MatchesOptions& options,
                                       const MatchesInput& input,
                                       int first_frame_idx,
                                       int num_threads,
                                       Progress& progress) {
  CheckInput(input);
  std::vector<int> offsets = options.pair_offsets;
  std::ranges::sort(offsets, std::greater<>());
  std::vector<FramePair> pairs;
  for (int b = first_frame_idx; b <= input.frames.back().frame_idx; ++b) {
    for (const int offset : offsets) {
      if (b - offset < input.frames.front().frame_idx) continue;
      pairs.emplace_back();
      pairs.back().frame_a = b - offset;
      pairs.back().frame_b = b;
    }
  }
  VerifyAll(options, input, false, num_threads, progress, &pairs);
  return pairs;
}

std::vector<FramePair> MatchLoops(const MatchesOptions& options,
                                  const MatchesInput& input,
                                  const Vocabulary& vocabulary,
                                  int num_threads,
                                  Progress& progress) {
  CheckInput(input);
  const auto& words = vocabulary.inverted_file.Words();
  if (words.size() != input.frames.size()) {
    throw DataError(
        "the vocabulary lists {} frames, the features {}; delete the vocabulary folder "
        "of this site and run make",
        words.size(),
        input.frames.size());
  }
  std::vector<std::vector<InvertedFile::Result>> candidates(words.size());
  ParallelFor(words.size(), num_threads, [&](std::size_t i) {
    const int b = static_cast<int>(i);
    const int before = b - options.loop_min_gap + 1;
    if (b % options.loop_stride != 0 || before <= 0 || options.loop_num_candidates == 0) return;
    const auto ranked =
        vocabulary.inverted_file.Query(words[i], 8 * options.loop_num_candidates, before);
    candidates[i] = Thin(ranked, options.loop_num_candidates, options.loop_min_gap / 2);
  });
  std::vector<FramePair> pairs;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (const InvertedFile::Result& candidate : candidates[i]) {
      pairs.emplace_back();
      pairs.back().frame_a = candidate.frame_idx;
      pairs.back().frame_b = static_cast<int>(i);
      pairs.back().score = candidate.score;
    }
  }
  VerifyAll(options, input, true, num_threads, progress, &pairs);
  return pairs;
}

}  // namespace nightmap
