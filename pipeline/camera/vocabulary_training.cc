// SPDX-License-Identifier: Apache-2.0
// Hierarchical k-means of VocabularyTree::Train.
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/camera/descriptor_distance.h"
#include "pipeline/camera/vocabulary_tree.h"

namespace nightmap {
namespace {

using Items = std::vector<int>;  // indices of training descriptors

struct Training {
  const std::vector<std::uint8_t>& descriptors;
  DescriptorKind kind;
  VocabularyTreeOptions options;
  std::size_t size;

  const std::uint8_t* Descriptor(int item) const {
    return &descriptors[static_cast<std::size_t>(item) * size];
  }
};

struct Clusters {
  std::vector<std::uint8_t> centres;  // k x size
  std::vector<Items> items;           // of each cluster, ascending

  std::size_t Count(std::size_t size) const { return centres.size() / size; }
};

void AppendCentre(const Training& training, int item, std::vector<std::uint8_t>* centres) {
  const std::uint8_t* descriptor = training.Descriptor(item);
  centres->insert(centres->end(), descriptor, descriptor + training.size);
}

// First position whose running sum of `weights` exceeds a uniform draw.
std::size_t DrawWeighted(const std::vector<std::int64_t>& weights,
                         std::int64_t sum,
                         Random* random) {
  auto rest = static_cast<std::int64_t>(random->Index(static_cast<std::size_t>(sum)));
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if ((rest -= weights[i]) < 0) return i;
  }
  return weights.size() - 1;
}

// k-means++: draws each next centre with a probability proportional to its distance (squared L2,
// Hamming) from the centres so far. Returns fewer than k when all items lie on a centre.
std::vector<std::uint8_t> SeedCentres(const Training& training,
                                      const Items& items,
                                      Random* random,
                                      int num_threads) {
  std::vector<std::uint8_t> centres;
  AppendCentre(training, items[random->Index(items.size())], &centres);
  std::vector<std::int64_t> weights(items.size(), std::numeric_limits<std::int32_t>::max());
  for (int k = 1; k < training.options.branching; ++k) {
    const std::uint8_t* last = &centres[centres.size() - training.size];
    ParallelForShort(items.size(), num_threads, [&](std::size_t i) {
      const int distance = DescriptorDistance(training.kind, training.Descriptor(items[i]), last);
      weights[i] = std::min<std::int64_t>(weights[i], distance);
    });
    const std::int64_t sum = std::accumulate(weights.begin(), weights.end(), std::int64_t{0});
    if (sum == 0) break;
    AppendCentre(training, items[DrawWeighted(weights, sum, random)], &centres);
  }
  return centres;
}

int NearestCentre(const Training& training,
                  const std::uint8_t* descriptor,
                  const Clusters& clusters) {
  int best = 0;
  int best_distance = std::numeric_limits<int>::max();
  for (std::size_t k = 0; k < clusters.Count(training.size); ++k) {
    const int distance =
        DescriptorDistance(training.kind, descriptor, &clusters.centres[k * training.size]);
    if (distance < best_distance) {
      best_distance = distance;
      best = static_cast<int>(k);
    }
  }
  return best;
}

void Assign(const Training& training, const Items& items, int num_threads, Clusters* clusters) {
  std::vector<int> nearest(items.size());
  ParallelForShort(items.size(), num_threads, [&](std::size_t i) {
    nearest[i] = NearestCentre(training, training.Descriptor(items[i]), *clusters);
  });
  clusters->items.assign(clusters->Count(training.size), {});
  for (std::size_t i = 0; i < items.size(); ++i) {
    clusters->items[static_cast<std::size_t>(nearest[i])].push_back(items[i]);
  }
}

void Mean(const Training& training, const Items& items, std::uint8_t* centre) {
  std::vector<std::int64_t> sums(training.size, 0);
  for (const int item : items) {
    const std::uint8_t* descriptor = training.Descriptor(item);
    for (std::size_t i = 0; i < training.size; ++i) sums[i] += descriptor[i];
  }
  const auto count = static_cast<std::int64_t>(items.size());
  for (std::size_t i = 0; i < training.size; ++i) {
    centre[i] = static_cast<std::uint8_t>((sums[i] + count / 2) / count);
  }
}

// The median of bits under the Hamming distance is their majority (ties: 0).
void BitwiseMajority(const Training& training, const Items& items, std::uint8_t* centre) {
  std::vector<std::array<int, 8>> ones(training.size, std::array<int, 8>{});
  for (const int item : items) {
    const std::uint8_t* descriptor = training.Descriptor(item);
    for (std::size_t i = 0; i < training.size; ++i) {
      for (std::size_t bit = 0; bit < 8; ++bit) ones[i][bit] += (descriptor[i] >> bit) & 1;
    }
  }
  const int half = static_cast<int>(items.size()) / 2;
  for (std::size_t i = 0; i < training.size; ++i) {
    int byte = 0;
    for (std::size_t bit = 0; bit < 8; ++bit) byte |= static_cast<int>(ones[i][bit] > half) << bit;
    centre[i] = static_cast<std::uint8_t>(byte);
  }
}

void MoveCentres(const Training& training, int num_threads, Clusters* clusters) {
  ParallelFor(clusters->items.size(), num_threads, [&](std::size_t k) {
    const Items& items = clusters->items[k];
    if (items.empty()) return;
    std::uint8_t* centre = &clusters->centres[k * training.size];
    if (training.kind == DescriptorKind::kRootSift) {
      Mean(training, items, centre);
    } else {
      BitwiseMajority(training, items, centre);
    }
  });
}

void DropEmpty(std::size_t size, Clusters* clusters) {
  Clusters kept;
  for (std::size_t k = 0; k < clusters->items.size(); ++k) {
    if (clusters->items[k].empty()) continue;
    const auto begin = clusters->centres.begin() + static_cast<std::ptrdiff_t>(k * size);
    kept.centres.insert(kept.centres.end(), begin, begin + static_cast<std::ptrdiff_t>(size));
    kept.items.push_back(std::move(clusters->items[k]));
  }
  *clusters = std::move(kept);
}

// Splits the items of a node. The last step is an assignment, so that the items of a child are the
// descriptors that reach it.
Clusters Split(const Training& training, const Items& items, int node, int num_threads) {
  if (static_cast<int>(items.size()) < training.options.min_node_descriptors) return {};
  Random random(static_cast<std::uint64_t>(training.options.seed),
                static_cast<std::uint64_t>(node));
  Clusters clusters;
  clusters.centres = SeedCentres(training, items, &random, num_threads);
  Assign(training, items, num_threads, &clusters);
  for (int i = 0; i < training.options.num_kmeans_iterations; ++i) {
    const std::vector<std::uint8_t> before = clusters.centres;
    MoveCentres(training, num_threads, &clusters);
    if (clusters.centres == before) break;
    Assign(training, items, num_threads, &clusters);
  }
  DropEmpty(training.size, &clusters);
  if (clusters.items.size() < 2) return {};
  return clusters;
}

// Splits all nodes of one level. Few large nodes share the threads inside, many small ones outside.
std::vector<Clusters> SplitLevel(const Training& training,
                                 const std::vector<Items>& level_items,
                                 std::size_t first_node,
                                 int num_threads) {
  const bool many = level_items.size() > 32;
  std::vector<Clusters> splits(level_items.size());
  ParallelFor(level_items.size(), many ? num_threads : 1, [&](std::size_t i) {
    const int node = static_cast<int>(first_node + i);
    splits[i] = Split(training, level_items[i], node, many ? 1 : num_threads);
  });
  return splits;
}

}  // namespace

VocabularyTree VocabularyTree::Train(const std::vector<std::uint8_t>& descriptors,
                                     DescriptorKind kind,
                                     const VocabularyTreeOptions& options,
                                     int num_threads) {
  const auto size = static_cast<std::size_t>(DescriptorSize(kind));
  if (descriptors.size() < size) {
    throw InputError({{"features", 0}},
                     InputError::Remedy::kInText,
                     "no descriptors to train on, here or in another shard; report_*.json beside "
                     "it says why: correct the recording or the options of features, and run make");
  }
  const Training training{descriptors, kind, options, size};
  std::vector<Node> nodes(1);
  std::vector<std::uint8_t> centres(size, 0);
  std::vector<Items> level_items(1, Items(descriptors.size() / size));
  std::iota(level_items[0].begin(), level_items[0].end(), 0);
  for (int level = 0; level < options.depth && !level_items.empty(); ++level) {
    const std::size_t first_node = nodes.size() - level_items.size();
    std::vector<Clusters> splits = SplitLevel(training, level_items, first_node, num_threads);
    level_items.clear();
    for (std::size_t i = 0; i < splits.size(); ++i) {
      if (splits[i].items.empty()) continue;
      nodes[first_node + i].first_child = static_cast<int>(nodes.size());
      nodes[first_node + i].num_children = static_cast<int>(splits[i].items.size());
      nodes.resize(nodes.size() + splits[i].items.size(), Node{0, 0, level + 1});
      centres.insert(centres.end(), splits[i].centres.begin(), splits[i].centres.end());
      std::move(splits[i].items.begin(), splits[i].items.end(), std::back_inserter(level_items));
    }
  }
  return {kind, options.depth, std::move(nodes), std::move(centres)};
}

}  // namespace nightmap
