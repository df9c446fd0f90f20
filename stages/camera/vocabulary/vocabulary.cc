// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/vocabulary/vocabulary.h"

#include <algorithm>
#include <numeric>

#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"

namespace nightmap {
namespace {

void CheckFrames(const std::vector<FrameFeatures>& frames) {
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].frame_idx != static_cast<int>(i)) {
      throw InputError({i == 0 ? InputName{"features", 0} : InputName{"features"}},
                       "frame_idx {} where {} is expected; give all shards in order",
                       frames[i].frame_idx,
                       i);
    }
  }
}

// `count` distinct indices of [0, size), ascending (partial Fisher-Yates shuffle).
std::vector<int> DrawIndices(int size, int count, Random random) {
  std::vector<int> indices(static_cast<std::size_t>(size));
  std::iota(indices.begin(), indices.end(), 0);
  count = std::min(count, size);
  for (int i = 0; i < count; ++i) {
    const auto pick =
        static_cast<std::size_t>(i) + random.Index(static_cast<std::size_t>(size - i));
    std::swap(indices[static_cast<std::size_t>(i)], indices[pick]);
  }
  indices.resize(static_cast<std::size_t>(count));
  std::sort(indices.begin(), indices.end());
  return indices;
}

// Draws equally many descriptors from every frame that has enough, so that a long stop of the
// camera does not fill the vocabulary with one view.
std::vector<std::uint8_t> DrawTraining(const VocabularyOptions& options,
                                       const SiteFeatures& features) {
  const FeaturesShard& heads = features.Heads();
  const auto size = static_cast<std::size_t>(heads.descriptor_size);
  const auto num_described =
      static_cast<int>(std::ranges::count_if(heads.frames, &FrameFeatures::IsDescribed));
  const int per_frame = std::max(1, options.max_training_descriptors / std::max(1, num_described));
  std::vector<std::uint8_t> training;
  for (std::size_t shard = 0; shard < features.NumShards(); ++shard) {
    const SiteFeatures::Shard of_shard = features.GetShard(shard);
    for (const FrameFeatures& frame : of_shard->frames) {
      if (!frame.IsDescribed()) continue;
      const Random random(static_cast<std::uint64_t>(options.tree.seed),
                          static_cast<std::uint64_t>(frame.frame_idx));
      for (const int i : DrawIndices(frame.NumFeatures(), per_frame, random)) {
        const std::uint8_t* descriptor = &frame.descriptors[static_cast<std::size_t>(i) * size];
        training.insert(training.end(), descriptor, descriptor + size);
      }
    }
  }
  return training;
}

}  // namespace

Vocabulary RunVocabulary(const VocabularyOptions& options,
                         const SiteFeatures& features,
                         Progress& progress,
                         int num_threads) {
  const FeaturesShard& heads = features.Heads();
  CheckFrames(heads.frames);
  Vocabulary vocabulary;
  vocabulary.tree =
      VocabularyTree::Train(DrawTraining(options, features), heads.kind, options.tree, num_threads);
  vocabulary.words.resize(heads.frames.size());
  progress.Start(heads.frames.size());
  for (std::size_t shard = 0; shard < features.NumShards(); ++shard) {
    const SiteFeatures::Shard of_shard = features.GetShard(shard);
    ParallelFor(of_shard->frames.size(), num_threads, [&](std::size_t i) {
      const FrameFeatures& frame = of_shard->frames[i];
      vocabulary.words[static_cast<std::size_t>(frame.frame_idx)] =
          vocabulary.tree.LeafWords(frame.descriptors, 1);
      progress.Advance();
    });
  }
  progress.Finish();
  return vocabulary;
}

int NumWords(const VocabularyTree& tree) {
  return static_cast<int>(std::count_if(tree.Nodes().begin(),
                                        tree.Nodes().end(),
                                        [](const auto& node) { return node.num_children == 0; }));
}

}  // namespace nightmap
