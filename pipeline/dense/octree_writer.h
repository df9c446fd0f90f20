// SPDX-License-Identifier: Apache-2.0
// Writes octrees directly from their leaves in depth-first order, because OctoMap's nodes, one
// allocation each, take several times the memory and the time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/dense/octree_encoders.h"
#include "pipeline/dense/octree_leaves.h"

namespace nightmap {

// `Encoder` is one of octree_encoders.h. Holds the bytes of the file and nothing else that grows.
template <typename Encoder>
class OctreeWriter {
 public:
  OctreeWriter(const std::filesystem::path& path, double resolution_m, Encoder encoder = Encoder())
      : path_(path), resolution_m_(resolution_m), encoder_(std::move(encoder)) {}

  Encoder& GetEncoder() { return encoder_; }

  // Throws DataError naming the file when the leaf begins before the end of the previous one.
  void Add(const PlacedLeaf& leaf) {
    CheckOrder(leaf);
    while (!open_.empty() && leaf.code >> 3 * Height() != code_ >> 3 * Height()) CloseNode();
    code_ = leaf.code;
    while (open_.empty() || Height() > leaf.height + 1) open_.push_back({encoder_.Open(), {}});
    open_.back().children[leaf.code >> 3 * leaf.height & 7] = encoder_.Leaf(leaf);
    end_ = leaf.code + (std::uint64_t{1} << 3 * leaf.height);
  }

  // Writes the file. Throws DataError naming it.
  void Close() {
    while (!open_.empty()) CloseNode();
    std::ostringstream head;
    head << Encoder::kType << "size " << encoder_.NumNodes() << "\nres " << resolution_m_
         << "\ndata\n";
    const std::string comments = fmt::format("{}{}{:016}\n", Encoder::kHead, kOctreeHashLine, 0);
    std::string bytes = encoder_.TakeBytes();
    bytes.insert(0, comments + head.str());
    const std::string hash = HashBytes(std::string_view(bytes).substr(comments.size()));
    bytes.replace(comments.size() - 1 - hash.size(), hash.size(), hash);
    WriteFile(path_, bytes);
  }

 private:
  struct OpenNode {
    std::size_t begin = 0;
    typename Encoder::Children children;
  };

  // Height of the lowest open node; nodes are open from the root to the parent of the last leaf.
  int Height() const { return kOctreeDepth + 1 - static_cast<int>(open_.size()); }

  void CloseNode() {
    const auto node = encoder_.Close(open_.back().begin, open_.back().children);
    const int height = Height();
    open_.pop_back();
    if (!open_.empty()) open_.back().children[code_ >> 3 * height & 7] = node;
  }

  void CheckOrder(const PlacedLeaf& leaf) const {
    if (leaf.code >= end_) return;
    const Eigen::Vector3d centre = ToVoxel(leaf, resolution_m_).centre_in_map;
    throw DataError("{}: two leaves of the octree overlap at ({}, {}, {})",
                    path_.string(),
                    centre.x(),
                    centre.y(),
                    centre.z());
  }

  std::filesystem::path path_;
  double resolution_m_;
  Encoder encoder_;
  std::vector<OpenNode> open_;
  std::uint64_t code_ = 0;  // of the last leaf
  std::uint64_t end_ = 0;   // code of the first voxel after it
};

}  // namespace nightmap
