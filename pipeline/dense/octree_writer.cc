// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/octree_writer.h"

#include <algorithm>
#include <utility>

#include "pipeline/dense/octree_reader.h"

namespace nightmap {
namespace {

template <typename Encoder>
void Write(const std::filesystem::path& path, const OccupancyTree& tree) {
  OctreeWriter<Encoder> writer(path, tree.resolution_m);
  for (const PlacedLeaf& leaf : PlaceLeaves(tree, path.string())) writer.Add(leaf);
  writer.Close();
}

// The leaves of several files as one list in depth-first order. Holds one leaf of each in memory.
class LeafMerger {
 public:
  explicit LeafMerger(const std::vector<std::filesystem::path>& paths) {
    for (const auto& path : paths) {
      readers_.emplace_back(path);
      const double resolution_m = readers_.front().Resolution_m();
      if (readers_.back().Resolution_m() != resolution_m) {
        throw DataError(
            "{}: octrees of {} m and {} m cannot be merged: make them with one resolution",
            path.string(),
            resolution_m,
            readers_.back().Resolution_m());
      }
      Advance(readers_.size() - 1);
    }
  }

  double Resolution_m() const { return readers_.empty() ? 0 : readers_.front().Resolution_m(); }

  std::optional<PlacedLeaf> Next() {
    if (heads_.empty()) return std::nullopt;
    std::ranges::pop_heap(heads_, Later);
    const Head head = heads_.back();
    heads_.pop_back();
    Advance(head.reader);
    return head.leaf;
  }

 private:
  struct Head {
    PlacedLeaf leaf;
    std::size_t reader = 0;
  };
  static bool Later(const Head& a, const Head& b) { return a.leaf.code > b.leaf.code; }

  void Advance(std::size_t reader) {
    const auto leaf = readers_[reader].Next();
    if (!leaf) return;
    heads_.push_back({*leaf, reader});
    std::ranges::push_heap(heads_, Later);
  }

  std::vector<OctreeReader> readers_;
  std::vector<Head> heads_;  // a heap with the first leaf at the front
};

}  // namespace

void WriteOctree(const std::filesystem::path& path, const OccupancyTree& tree) {
  Write<ValueEncoder>(path, tree);
}

void WriteBinaryOctree(const std::filesystem::path& path, const OccupancyTree& tree) {
  Write<StateEncoder>(path, tree);
}

VoxelCounts MergeOctrees(const std::vector<std::filesystem::path>& parts,
                         const std::filesystem::path& ot,
                         const std::filesystem::path& bt) {
  LeafMerger merger(parts);
  OctreeWriter<ValueEncoder> values(ot, merger.Resolution_m());
  OctreeWriter<StateEncoder> states(bt, merger.Resolution_m());
  // The whole has no more nodes than its parts. Reserves for them, because growing would hold the
  // bytes twice.
  std::uintmax_t num_bytes = 0;
  for (const auto& path : parts) num_bytes += std::filesystem::file_size(path);
  values.GetEncoder().Reserve(num_bytes);
  VoxelCounts counts;
  while (const auto leaf = merger.Next()) {
    values.Add(*leaf);
    states.Add(*leaf);
    counts.Add(leaf->height, leaf->Occupied());
  }
  values.Close();
  states.Close();
  return counts;
}

}  // namespace nightmap
