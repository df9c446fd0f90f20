// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/octree_io.h"

#include <octomap/ColorOcTree.h>
#include <octomap/OcTree.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"

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

// Walks the nodes before OctoMap does, because its reader recurses without end on a short file.
class NodeChecker {
 public:
  NodeChecker(std::string_view data, std::size_t payload) : data_(data), payload_(payload) {}

  // Nothing wrong: empty string.
  std::string Check(std::size_t num_nodes) {
    std::string problem = num_nodes == 0 ? "" : CheckNode(0);
    if (problem.empty() && (num_nodes_ != num_nodes || offset_ != data_.size())) {
      problem = "field size does not agree with the data";
    }
    return problem;
  }

 private:
  std::string CheckNode(int depth) {
    if (depth > kOctreeDepth) return "deeper than 16 levels";
    if (data_.size() - offset_ < payload_ + 1) return "truncated";
    float log_odds = 0;
    std::memcpy(&log_odds, data_.data() + offset_, sizeof(log_odds));
    if (!std::isfinite(log_odds)) return "field log-odds is not finite";
    unsigned num_children =
        static_cast<unsigned>(std::popcount(static_cast<std::uint8_t>(data_[offset_ + payload_])));
    offset_ += payload_ + 1;
    ++num_nodes_;
    std::string problem;
    for (; num_children > 0 && problem.empty(); --num_children) problem = CheckNode(depth + 1);
    return problem;
  }

  std::string_view data_;
  std::size_t payload_;
  std::size_t offset_ = 0;
  std::size_t num_nodes_ = 0;
};

template <typename Tree>
OccupancyTree ListLeaves(const Header& header, const std::string& data) {
  Tree tree(header.resolution_m);
  std::istringstream stream(data);
  if (header.num_nodes > 0) tree.readData(stream);
  OccupancyTree result;
  result.resolution_m = header.resolution_m;
  for (auto leaf = tree.begin_leafs(); leaf != tree.end_leafs(); ++leaf) {
    OccupancyVoxel voxel;
    voxel.centre_in_map = {leaf.getX(), leaf.getY(), leaf.getZ()};
    voxel.size_m = leaf.getSize();
    voxel.log_odds = leaf->getLogOdds();
    if constexpr (std::is_same_v<Tree, octomap::ColorOcTree>) {
      voxel.rgb = {leaf->getColor().r, leaf->getColor().g, leaf->getColor().b};
    }
    result.leaves.push_back(voxel);
  }
  return result;
}

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
  const std::string data = bytes.substr(header.data_begin);
  const std::string problem = NodeChecker(data, colored ? 7 : 4).Check(header.num_nodes);
  if (!problem.empty()) {
    throw DataError("{}: {}; make the octree again", path.string(), problem);
  }
  return colored ? ListLeaves<octomap::ColorOcTree>(header, data)
                 : ListLeaves<octomap::OcTree>(header, data);
}

}  // namespace nightmap
