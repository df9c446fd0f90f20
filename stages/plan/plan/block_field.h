// SPDX-License-Identifier: Apache-2.0
// Heuristic for the cost to the goal: exact in reachability, coarse in cost.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "stages/plan/plan/cost_map.h"

namespace nightmap {

// Divides the map into blocks of 8 x 8 cells. A node is a set of free cells of a block that reach
// each other inside the block, and nodes with adjacent cells are neighbours. So a cell reaches the
// goal exactly when its node does. (Botea, Mueller and Schaeffer, Near optimal hierarchical
// path-finding, 2004, build a graph of blocks in another way.)
class BlockField {
 public:
  BlockField(const CostMap& map, const Eigen::Vector2i& goal);

  // Reaches and CostToGoal are for free cells.
  bool Reaches(const Eigen::Vector2i& cell) const { return nodes_[NodeOf(cell)].cost < kUnreached; }
  // Estimated cost in cells from a cell that reaches the goal; it may be too high.
  double CostToGoal(const Eigen::Vector2i& cell) const;

 private:
  static constexpr int kSide = 8;
  static constexpr float kUnreached = 1e30F;

  struct Node {
    std::uint64_t cells = 0;  // bit 8 * y + x of the block
    float weight = 0;         // estimated cost per metre through it
    float cost = kUnreached;  // to the goal, in cells
    Eigen::Vector2i centre = Eigen::Vector2i::Zero();
    std::size_t block = 0;
    std::size_t next = 0;  // neighbour towards the goal; the goal's is itself
  };

  struct Neighbour {
    std::size_t node = 0;
    float distance = 0;  // cells
  };

  std::size_t Stride() const { return static_cast<std::size_t>(num_columns_) + 2; }
  std::size_t NodeOf(const Eigen::Vector2i& cell) const;
  void MakeNodes(const CostMap& map);
  void AddNodes(const CostMap& map, int column, int row);
  void Spread(std::size_t goal);
  void FindNeighbours(std::size_t node, std::vector<Neighbour>& neighbours) const;

  int num_columns_ = 0;  // number of block columns; a rim of empty blocks surrounds them
  int num_rows_ = 0;
  std::vector<std::size_t> first_node_;  // by block, and one beyond
  std::vector<Node> nodes_;
};

}  // namespace nightmap
