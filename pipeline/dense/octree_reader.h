// SPDX-License-Identifier: Apache-2.0
// Reads OctoMap's `.ot` files leaf by leaf, so that a tree need not fit into memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/dense/octree_leaves.h"

namespace nightmap {

// Leaves come depth first, as they are in the file. The constructor throws DataError naming the
// file when it is of another type than ColorOcTree or OcTree (white leaves), and the first Next
// when it is damaged: by its hash, and in a file of another program, which has none, by its
// structure and NaN. So no work is done on leaves that are none: a zero is a leaf that is occupied,
// and may be as large as a city.
class OctreeReader {
 public:
  explicit OctreeReader(const std::filesystem::path& path);

  double Resolution_m() const { return resolution_m_; }
  // The next leaf; nothing after the last.
  std::optional<PlacedLeaf> Next();

 private:
  struct Inner {
    std::uint64_t code = 0;
    int height = 0;
    unsigned children = 0;  // one bit per child that is not read yet
  };

  void ReadHeader();
  void CheckData();
  std::optional<PlacedLeaf> ReadNode(std::uint64_t code, int height);
  void CheckEnd();
  [[noreturn]] void Fail(const std::string& problem) const;

  std::filesystem::path path_;
  std::ifstream stream_;
  double resolution_m_ = 0;
  std::size_t color_size_ = 0;  // bytes
  std::size_t num_nodes_ = 0;   // from the header
  std::string hash_;            // of the bytes from hashed_from_ on; empty: none in the header
  std::int64_t hashed_from_ = 0;
  bool is_checked_ = false;
  std::size_t num_read_ = 0;
  std::vector<Inner> open_;  // path from the root to the current position
};

// All leaves of a file; callable repeatedly.
LeafSource LeavesOfFile(const std::filesystem::path& path);

}  // namespace nightmap
