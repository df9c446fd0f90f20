// SPDX-License-Identifier: Apache-2.0
// Smallest voxels in blocks of 8 x 8 x 8, addressed by Morton code: the upper bits name the block,
// the lowest nine the voxel in it. Ascending codes are an octree's leaves depth first, and 64
// successive voxels form a cube of 4 x 4 x 4.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace nightmap {

constexpr int kBlockShift = 9;
constexpr std::size_t kBlockVoxels = 1 << kBlockShift;
constexpr std::size_t kBlockWords = kBlockVoxels / 64;

inline std::uint64_t BlockOf(std::uint64_t voxel) { return voxel >> kBlockShift; }
inline std::size_t IndexInBlock(std::uint64_t voxel) { return voxel & (kBlockVoxels - 1); }

// A set of voxels of one block.
struct BlockBits {
  std::array<std::uint64_t, kBlockWords> words{};

  bool Test(std::size_t index) const { return words[index / 64] >> index % 64 & 1; }
  void Set(std::size_t index) { words[index / 64] |= std::uint64_t{1} << index % 64; }
  // Returns whether it was new.
  bool Insert(std::size_t index) {
    const bool is_new = !Test(index);
    Set(index);
    return is_new;
  }
  bool None() const { return words == std::array<std::uint64_t, kBlockWords>{}; }

  std::size_t Count() const {
    int count = 0;
    for (const std::uint64_t word : words) count += std::popcount(word);
    return static_cast<std::size_t>(count);
  }
  // Number of voxels of the set before `index`.
  std::size_t Rank(std::size_t index) const {
    int count = std::popcount(words[index / 64] & ((std::uint64_t{1} << index % 64) - 1));
    for (std::size_t word = 0; word < index / 64; ++word) count += std::popcount(words[word]);
    return static_cast<std::size_t>(count);
  }
  // Calls visit(index) in ascending order.
  template <typename Visit>
  void ForEach(const Visit& visit) const {
    for (std::size_t word = 0; word < kBlockWords; ++word) {
      for (std::uint64_t bits = words[word]; bits != 0; bits &= bits - 1) {
        visit(64 * word + static_cast<std::size_t>(std::countr_zero(bits)));
      }
    }
  }

  BlockBits& operator&=(const BlockBits& other) {
    for (std::size_t word = 0; word < kBlockWords; ++word) words[word] &= other.words[word];
    return *this;
  }
  BlockBits& operator|=(const BlockBits& other) {
    for (std::size_t word = 0; word < kBlockWords; ++word) words[word] |= other.words[word];
    return *this;
  }
  bool operator==(const BlockBits&) const = default;
};

// Values by block, or by any other code, in the order of their first access. A hash table with open
// addressing, because a keyframe's rays make many accesses. Not thread-safe.
template <typename T>
class BlockMap {
 public:
  struct Entry {
    std::uint64_t block = 0;
    T value;
  };

  // Index in Entries() of the block's entry, which is created if new.
  std::size_t IndexOf(std::uint64_t block) {
    if (2 * (entries_.size() + 1) > slots_.size()) Grow();
    std::uint32_t& slot = slots_[Slot(block)];
    if (slot == 0) {
      entries_.push_back({block, {}});
      slot = static_cast<std::uint32_t>(entries_.size());
    }
    return slot - 1;
  }
  // Null when the block has no entry.
  const T* Find(std::uint64_t block) const {
    if (entries_.empty()) return nullptr;
    const std::uint32_t slot = slots_[Slot(block)];
    return slot == 0 ? nullptr : &entries_[slot - 1].value;
  }
  T& At(std::uint64_t block) { return entries_[IndexOf(block)].value; }

  std::vector<Entry>& Entries() { return entries_; }
  const std::vector<Entry>& Entries() const { return entries_; }

 private:
  // Slot of the block, or the empty slot where it belongs.
  std::size_t Slot(std::uint64_t block) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = block * 0x9E3779B97F4A7C15U >> std::countl_zero(mask);  // Fibonacci hashing
    while (slots_[slot] != 0 && entries_[slots_[slot] - 1].block != block) slot = (slot + 1) & mask;
    return slot;
  }

  void Grow() {
    slots_.assign(slots_.empty() ? 1024 : 2 * slots_.size(), 0);
    for (std::uint32_t i = 0; i < entries_.size(); ++i) slots_[Slot(entries_[i].block)] = i + 1;
  }

  std::vector<std::uint32_t> slots_;  // 1 + index into entries_; 0: empty
  std::vector<Entry> entries_;
};

}  // namespace nightmap
