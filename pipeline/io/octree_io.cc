// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/octree_io.h"

#include <cmath>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/octree_leaves.h"

namespace nightmap {
namespace {

struct Header {
  std::string type;
  std::size_t num_nodes = 0;
  double resolution_m = 0;
  std::size_t data_begin = 0;  // byte offset
};

// `# Octomap OcTree file`, then `key value` lines up to `data`.
Header ParseHeader(const std::string& bytes, const std::filesystem::path& path) {
  constexpr std::string_view kFirstLine = "# Octomap OcTree file";
  constexpr std::string_view kLastLine = "\ndata\n";
  if (bytes.substr(0, kFirstLine.size()) != kFirstLine) {
    throw DataError("{}: not an OctoMap .ot file; make it with the octree stage", path.string());
  }
  Header header;
  const std::size_t end = bytes.find(kLastLine);
  std::istringstream lines(bytes.substr(0, end));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::string key;
    fields >> key;
    if (key == "id") fields >> header.type;
    if (key == "size") fields >> header.num_nodes;
    if (key == "res") fields >> header.resolution_m;
  }
  if (end == std::string::npos || !(header.resolution_m > 0) ||
      !std::isfinite(header.resolution_m)) {
    throw DataError("{}: the header ends early or lacks res; make the octree again", path.string());
  }
  header.data_begin = end + kLastLine.size();
  return header;
}

// Each node is its log-odds, its color if the tree has any, and a byte with a bit for each child;
// then its children. Inner nodes say nothing that their leaves do not.
class NodeReader {
 public:
  NodeReader(std::string_view data, const Header& header, bool colored)
      : data_(data), header_(header), color_size_(colored ? 3 : 0) {}

  // Nothing wrong: empty string.
  std::string Read(OccupancyTree& tree) {
    tree.resolution_m = header_.resolution_m;
    tree.leaves.reserve(data_.size() / NodeSize());
    std::string problem;
    if (header_.num_nodes > 0) problem = ReadNode({0, 0, {}, kOctreeDepth}, tree);
    if (problem.empty() && (num_nodes_ != header_.num_nodes || offset_ != data_.size())) {
      problem = "field size does not agree with the data";
    }
    return problem;
  }

 private:
  std::string ReadNode(PlacedLeaf node, OccupancyTree& tree) {
    if (data_.size() - offset_ < NodeSize()) return "truncated";
    std::memcpy(&node.log_odds, &data_[offset_], kValueSize);
    if (!std::isfinite(node.log_odds)) return "field log-odds is not finite";
    node.rgb = {255, 255, 255};
    std::memcpy(node.rgb.data(), &data_[offset_ + kValueSize], color_size_);
    const unsigned children = static_cast<std::uint8_t>(data_[offset_ + NodeSize() - 1]);
    offset_ += NodeSize();
    ++num_nodes_;
    if (children == 0) return AddLeaf(node, tree);
    if (node.height == 0) return "deeper than 16 levels";
    std::string problem;
    for (std::uint64_t child = 0; child < 8 && problem.empty(); ++child) {
      if ((children >> child & 1) == 0) continue;
      const auto height = static_cast<std::uint8_t>(node.height - 1);
      problem = ReadNode({node.code | child << 3 * height, 0, {}, height}, tree);
    }
    return problem;
  }

  static constexpr std::size_t kValueSize = sizeof(float);
  std::size_t NodeSize() const { return kValueSize + color_size_ + 1; }

  std::string AddLeaf(const PlacedLeaf& leaf, OccupancyTree& tree) const {
    if (leaf.height == kOctreeDepth) return "all space is one leaf";
    tree.leaves.push_back(ToVoxel(leaf, header_.resolution_m));
    return "";
  }

  std::string_view data_;
  const Header& header_;
  std::size_t color_size_;
  std::size_t offset_ = 0;
  std::size_t num_nodes_ = 0;
};

}  // namespace

double OctreeReach_m(double resolution_m) { return resolution_m * (1 << (kOctreeDepth - 1)); }

OccupancyTree ReadOctree(const std::filesystem::path& path) {
  const std::string bytes = ReadFile(path);
  const Header header = ParseHeader(bytes, path);
  const bool colored = header.type == "ColorOcTree";
  if (!colored && header.type != "OcTree") {
    throw DataError(
        "{}: field id is '{}'; ColorOcTree or OcTree is needed", path.string(), header.type);
  }
  OccupancyTree tree;
  const std::string_view data = std::string_view(bytes).substr(header.data_begin);
  const std::string problem = NodeReader(data, header, colored).Read(tree);
  if (!problem.empty()) {
    throw DataError("{}: {}; make the octree again", path.string(), problem);
  }
  return tree;
}

}  // namespace nightmap
