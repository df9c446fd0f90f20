// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/loops/same_node_matcher.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "pipeline/base/input_error.h"
#include "pipeline/camera/descriptor_distance.h"

namespace nightmap {
namespace {

// The ancestor of each node at `level`, or the node itself if it is not below that level.
std::vector<int> Ancestors(const VocabularyTree& tree, int level) {
  const auto& nodes = tree.Nodes();
  std::vector<int> ancestors(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].level <= level) ancestors[i] = static_cast<int>(i);
    for (int child = 0; child < nodes[i].num_children; ++child) {
      ancestors[static_cast<std::size_t>(nodes[i].first_child + child)] = ancestors[i];
    }
  }
  return ancestors;
}

struct Best {
  int feature = -1;
  int distance = std::numeric_limits<int>::max();
  int second_distance = std::numeric_limits<int>::max();

  void Offer(int candidate, int candidate_distance) {
    if (candidate_distance < distance) {
      second_distance = distance;
      distance = candidate_distance;
      feature = candidate;
    } else {
      second_distance = std::min(second_distance, candidate_distance);
    }
  }
};

}  // namespace

SameNodeMatcher::SameNodeMatcher(const Vocabulary& vocabulary, int level)
    : vocabulary_(vocabulary), ancestors_(Ancestors(vocabulary.tree, level)) {}

std::vector<SameNodeMatcher::Entry> SameNodeMatcher::EntriesOf(const FrameFeatures& frame) const {
  const auto& words = vocabulary_.words.at(static_cast<std::size_t>(frame.frame_idx));
  if (std::cmp_greater(words.size(), frame.NumFeatures())) {
    throw InputError({{"vocabulary"}},
                     "lists {} words of frame {}, which has {} features",
                     words.size(),
                     frame.frame_idx,
                     frame.NumFeatures());
  }
  std::vector<Entry> entries;
  for (std::size_t i = 0; i < words.size(); ++i) {
    entries.emplace_back(ancestors_[static_cast<std::size_t>(words[i])], static_cast<int>(i));
  }
  std::ranges::sort(entries);
  return entries;
}

std::vector<FeatureMatch> SameNodeMatcher::Match(const FrameFeatures& a,
                                                 const FrameFeatures& b,
                                                 double max_ratio) const {
  const DescriptorKind kind = vocabulary_.tree.Kind();
  std::vector<Best> best_of_a(static_cast<std::size_t>(a.NumFeatures()));
  std::vector<Best> best_of_b(static_cast<std::size_t>(b.NumFeatures()));
  const std::vector<Entry> entries_b = EntriesOf(b);
  for (const auto& [node, i] : EntriesOf(a)) {
    auto entry = std::ranges::lower_bound(entries_b, Entry{node, 0});
    for (; entry != entries_b.end() && entry->first == node; ++entry) {
      const int j = entry->second;
      const int distance =
          DescriptorDistance(kind, a.Feature(i).Descriptor(kind), b.Feature(j).Descriptor(kind));
      best_of_a[static_cast<std::size_t>(i)].Offer(j, distance);
      best_of_b[static_cast<std::size_t>(j)].Offer(i, distance);
    }
  }
  std::vector<FeatureMatch> matches;
  for (int i = 0; i < a.NumFeatures(); ++i) {
    const Best& best = best_of_a[static_cast<std::size_t>(i)];
    if (best.feature >= 0 && best_of_b[static_cast<std::size_t>(best.feature)].feature == i &&
        PassesRatioTest(kind, best.distance, best.second_distance, max_ratio)) {
      matches.push_back({i, best.feature});
    }
  }
  return matches;
}

}  // namespace nightmap
