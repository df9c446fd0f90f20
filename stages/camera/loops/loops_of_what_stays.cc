// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/loops/loops_of_what_stays.h"

#include <utility>

namespace nightmap {
namespace {

// Without the words of features that were left out. A frame has no more words than features.
InvertedFile WordsLeft(const InvertedFile& inverted_file, const IndicesBefore& indices_before) {
  std::vector<std::vector<int>> left;
  for (std::size_t i = 0; i < inverted_file.Words().size(); ++i) {
    const std::vector<int>& words = inverted_file.Words()[i];
    std::vector<int>& of_frame = left.emplace_back();
    if (i >= indices_before.size()) continue;
    for (const int feature : indices_before[i]) {
      if (std::cmp_less(feature, words.size())) {
        of_frame.push_back(words[static_cast<std::size_t>(feature)]);
      }
    }
  }
  return InvertedFile(left);
}

}  // namespace

std::vector<FramePair> RunLoopsOfWhatStays(const LoopsOptions& options,
                                           FramesWithFeatures input,
                                           Vocabulary vocabulary,
                                           const std::vector<FrameRecord>& masked_frames,
                                           const FrameReader& masks,
                                           Progress& progress,
                                           int num_threads) {
  const IndicesBefore indices_before =
      LeaveOut(masked_frames, input.cameras, masks, &input.features);
  vocabulary.inverted_file = WordsLeft(vocabulary.inverted_file, indices_before);
  auto pairs = RunLoops(options, input, vocabulary, progress, num_threads);
  const auto before = [&](int frame, int feature) {
    return indices_before[static_cast<std::size_t>(frame)][static_cast<std::size_t>(feature)];
  };
  for (FramePair& pair : pairs) {
    for (FeatureMatch& match : pair.inliers) {
      match = {before(pair.frame_a, match.a), before(pair.frame_b, match.b)};
    }
  }
  return pairs;
}

}  // namespace nightmap
