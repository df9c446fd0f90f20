// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/loops/loops_of_what_stays.h"

#include <algorithm>
#include <utility>

namespace nightmap {
namespace {

// Takes the words of features that were left out. A frame has no more words than features.
void KeepWords(const IndicesBefore& indices_before, std::vector<std::vector<int>>* words) {
  for (std::size_t i = 0; i < std::min(words->size(), indices_before.size()); ++i) {
    if (!indices_before[i]) continue;
    std::vector<int> left;
    for (const int feature : *indices_before[i]) {
      if (std::cmp_less(feature, (*words)[i].size())) {
        left.push_back((*words)[i][static_cast<std::size_t>(feature)]);
      }
    }
    (*words)[i] = std::move(left);
  }
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
      UnmaskedFeatures(masked_frames, input.cameras, masks, input.features);
  KeepWords(indices_before, &vocabulary.words);
  input.features = KeepFeatures(input.features, indices_before);
  auto pairs = RunLoops(options, input, vocabulary, progress, num_threads);
  const auto before = [&](int frame, int feature) {
    const auto& left = indices_before[static_cast<std::size_t>(frame)];
    return left ? (*left)[static_cast<std::size_t>(feature)] : feature;
  };
  for (FramePair& pair : pairs) {
    for (FeatureMatch& match : pair.inliers) {
      match = {before(pair.frame_a, match.a), before(pair.frame_b, match.b)};
    }
  }
  return pairs;
}

}  // namespace nightmap
