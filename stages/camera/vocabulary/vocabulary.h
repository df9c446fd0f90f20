// SPDX-License-Identifier: Apache-2.0
// vocabulary: trains the vocabulary tree on the site's own descriptors and assigns every feature of
// every described frame to its leaf; tracked frames have no words.
#pragma once

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/camera/vocabulary_io.h"
#include "pipeline/io/site_features.h"

namespace nightmap {

struct VocabularyOptions {
  VocabularyTreeOptions tree;
  OPTION_AT("branching", tree.branching, {2, 64}, "children per node");
  OPTION_AT("depth", tree.depth, {1, VocabularyTreeOptions::kMaxDepth}, "levels below the root");
  OPTION_AT("num_kmeans_iterations", tree.num_kmeans_iterations, {1, 100},
            "largest number of k-means iterations per node");
  OPTION(int, max_training_descriptors, 200000, {100, 1e8},
         "training descriptors, drawn evenly over all frames");
  OPTION_AT("seed", tree.seed, {0, 2e9}, "seed of the draw and of k-means");
  REGISTER_OPTIONS();
};

// Frames must be in order of frame_idx from zero. Goes through the shards twice, one at a time.
// Throws DataError when there is no descriptor. The same at any number of threads.
Vocabulary RunVocabulary(const VocabularyOptions& options,
                         const SiteFeatures& features,
                         Progress& progress,
                         int num_threads);

// Number of leaves of a tree: the size of the vocabulary.
int NumWords(const VocabularyTree& tree);

}  // namespace nightmap
