// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/block_field.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>

#include "stages/plan/plan/bucket_queue.h"

namespace nightmap {
namespace {

constexpr std::uint64_t kLeftColumn = 0x0101010101010101;
constexpr std::uint64_t kRightColumn = kLeftColumn << 7;
constexpr float kDiagonalRatio = 1.41421356F;
constexpr float kFieldKeysPerCell = 16;
// Weight of the extra cost of a block's cheapest cell, since a path does not keep to that cell. A
// larger weight makes the search faster and its choice between routes worse.
constexpr float kNearness = 2;
// Share of a block's way that is in the margin of obstacles when all its cells are: gaps are short.
// With more the search goes around gaps that it should take.
constexpr float kMarginShare = 0.25F;
constexpr int kKeyShift = 5;
constexpr std::int64_t kMaxKeyRise = 1 << 16;

// The cells of `free` that the cell `seed` reaches by 4-connected steps.
std::uint64_t Flood(std::uint64_t seed, std::uint64_t free) {
  std::uint64_t reached = seed;
  while (true) {
    const std::uint64_t right = (reached << 1) & ~kLeftColumn;
    const std::uint64_t left = (reached >> 1) & ~kRightColumn;
    const std::uint64_t grown = (reached | right | left | reached << 8 | reached >> 8) & free;
    if (grown == reached) return reached;
    reached = grown;
  }
}

struct BlockCells {
  std::uint64_t free = 0;  // bit 8 * y + x
  int least_cost = 0;      // of a free cell
};

// Packs eight bytes of 0 or 1 into eight bits.
std::uint64_t ToBits(const std::uint8_t* bytes) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, sizeof word);
  return (word * 0x0102040810204080) >> 56;
}

BlockCells ReadBlock(const CostMap& map,
                     const Eigen::Vector2i& first,
                     const Eigen::Vector2i& size) {
  std::array<std::uint16_t, 64> costs = {};  // not free beyond the map
  for (int y = 0; y < size.y(); ++y) {
    const std::uint16_t* row = map.costs.data() + map.Index(first + Eigen::Vector2i(0, y));
    std::uint16_t* copy = &costs[static_cast<std::size_t>(8 * y)];
    if (size.x() == 8) {
      std::copy_n(row, 8, copy);
    } else {
      std::copy_n(row, size.x(), copy);
    }
  }
  std::uint16_t least = 0xffff;  // minus one, so that cells that are not free have the largest cost
  std::array<std::uint8_t, 64> is_free;
  for (std::size_t i = 0; i < 64; ++i) {
    const auto cost = static_cast<std::uint16_t>(costs[i] - 1);
    least = cost < least ? cost : least;
    is_free[i] = costs[i] != 0 ? 1 : 0;
  }
  BlockCells block{0, least + 1};
  for (std::size_t y = 0; y < 8; ++y) block.free |= ToBits(&is_free[8 * y]) << (8 * y);
  return block;
}

enum Side { kRight, kLeft, kUp, kDown };

// Whether cells of a block are adjacent to cells of the next block on a side.
bool Touch(std::uint64_t cells, std::uint64_t others, Side side) {
  switch (side) {
    case kRight:
      return ((cells >> 7) & others & kLeftColumn) != 0;
    case kLeft:
      return ((others >> 7) & cells & kLeftColumn) != 0;
    case kUp:
      return ((cells >> 56) & others) != 0;
    default:
      return ((others >> 56) & cells) != 0;
  }
}

float Octile(const Eigen::Vector2i& a, const Eigen::Vector2i& b) {
  const int dx = std::abs(a.x() - b.x());
  const int dy = std::abs(a.y() - b.y());
  return static_cast<float>(std::max(dx, dy)) +
         (kDiagonalRatio - 1) * static_cast<float>(std::min(dx, dy));
}

}  // namespace

BlockField::BlockField(const CostMap& map, const Eigen::Vector2i& goal)
    : num_columns_((map.width + kSide - 1) / kSide), num_rows_((map.height + kSide - 1) / kSide) {
  MakeNodes(map);
  const std::size_t node = NodeOf(goal);
  nodes_[node].centre = goal;
  Spread(node);
}

void BlockField::MakeNodes(const CostMap& map) {
  first_node_.assign(Stride() + 1, 0);
  for (int row = 0; row < num_rows_; ++row) {
    for (int column = 0; column < num_columns_; ++column) {
      first_node_.push_back(nodes_.size());
      AddNodes(map, column, row);
    }
    first_node_.insert(first_node_.end(), 2, nodes_.size());  // the rim
  }
  first_node_.insert(first_node_.end(), Stride(), nodes_.size());
}

void BlockField::AddNodes(const CostMap& map, int column, int row) {
  const int x0 = column * kSide;
  const int y0 = row * kSide;
  const BlockCells block =
      ReadBlock(map, {x0, y0}, {std::min(kSide, map.width - x0), std::min(kSide, map.height - y0)});
  const float least_weight =
      static_cast<float>(block.least_cost) / static_cast<float>(CostMap::kUnitCost);
  const float margin_weight =
      static_cast<float>(map.margin_cost) / static_cast<float>(CostMap::kUnitCost);
  const float in_margin = margin_weight > 0 && least_weight > margin_weight ? margin_weight : 0;
  const float weight = 1 + kNearness * (least_weight - in_margin - 1) + kMarginShare * in_margin;
  const std::size_t index = first_node_.size() - 1;
  std::uint64_t left = block.free;
  while (left != 0) {
    const std::uint64_t cells = ~left == 0 ? left : Flood(left & (~left + 1), left);
    nodes_.push_back(
        {cells, weight, kUnreached, {x0 + kSide / 2, y0 + kSide / 2}, index, nodes_.size()});
    left &= ~cells;
  }
}

std::size_t BlockField::NodeOf(const Eigen::Vector2i& cell) const {
  const auto column = static_cast<std::size_t>(cell.x() / kSide);
  const auto row = static_cast<std::size_t>(cell.y() / kSide);
  const std::uint64_t bit = std::uint64_t{1} << (kSide * (cell.y() % kSide) + cell.x() % kSide);
  std::size_t node = first_node_[(row + 1) * Stride() + column + 1];
  while ((nodes_[node].cells & bit) == 0) ++node;
  return node;
}

// A step to a diagonal block goes through a node adjacent to both.
void BlockField::FindNeighbours(std::size_t node, std::vector<Neighbour>& neighbours) const {
  const auto stride = static_cast<std::ptrdiff_t>(Stride());
  const std::array<std::ptrdiff_t, 4> offsets = {1, -1, stride, -stride};
  const auto visit_touching = [&](std::size_t from, Side side, const auto& visit) {
    const std::size_t block = nodes_[from].block + static_cast<std::size_t>(offsets[side]);
    for (std::size_t i = first_node_[block]; i < first_node_[block + 1]; ++i) {
      if (Touch(nodes_[from].cells, nodes_[i].cells, side)) visit(i);
    }
  };
  neighbours.clear();
  for (const Side side : {kRight, kLeft, kUp, kDown}) {
    const std::array<Side, 2> turns =
        side <= kLeft ? std::array<Side, 2>{kUp, kDown} : std::array<Side, 2>{kRight, kLeft};
    visit_touching(node, side, [&](std::size_t beside) {
      neighbours.push_back({beside, kSide});
      for (const Side turn : turns) {
        visit_touching(beside, turn, [&](std::size_t diagonal) {
          neighbours.push_back({diagonal, kSide * kDiagonalRatio});
        });
      }
    });
  }
}

// Dijkstra's algorithm; corrects nodes that leave the queue too early.
void BlockField::Spread(std::size_t goal) {
  struct Open {
    std::size_t node;
    float cost;
  };
  BucketQueue<Open> queue(kKeyShift, kMaxKeyRise);
  nodes_[goal].cost = 0;
  queue.Push(0, {goal, 0});
  std::vector<Neighbour> neighbours;
  while (!queue.IsEmpty()) {
    const Open open = queue.Pop();
    const Node& node = nodes_[open.node];
    if (open.cost != node.cost) continue;
    FindNeighbours(open.node, neighbours);
    for (const Neighbour& neighbour : neighbours) {
      Node& other = nodes_[neighbour.node];
      const float cost = node.cost + neighbour.distance * (node.weight + other.weight) / 2;
      if (cost >= other.cost) continue;
      other.cost = cost;
      other.next = open.node;
      queue.Push(static_cast<std::int64_t>(cost * kFieldKeysPerCell), {neighbour.node, cost});
    }
  }
}

// Aims at the node after the next, so that the estimate also falls steadily within a block.
double BlockField::CostToGoal(const Eigen::Vector2i& cell) const {
  const Node& own = nodes_[NodeOf(cell)];
  const Node& ahead = nodes_[nodes_[own.next].next];
  const float distance = Octile(own.centre, ahead.centre);
  const float weight = distance > 0 ? (own.cost - ahead.cost) / distance : own.weight;
  return ahead.cost + weight * Octile(cell, ahead.centre);
}

}  // namespace nightmap
