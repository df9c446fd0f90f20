// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/octree_reader.h"

#include <array>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <sstream>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"

namespace nightmap {
namespace {

// Beyond these a count of voxels, or of grid cells, does not fit an integer.
constexpr double kMinLeafEdge_m = 1e-4;
constexpr double kMaxLeafEdge_m = 1e4;

}  // namespace

OctreeReader::OctreeReader(const std::filesystem::path& path)
    : path_(path), stream_(path, std::ios::binary) {
  if (!stream_) throw DataError("{}: cannot read: {}", path.string(), std::strerror(errno));
  ReadHeader();
}

// `# Octomap OcTree file`, then `key value` lines up to `data`.
void OctreeReader::ReadHeader() {
  constexpr std::string_view kFirstLine = "# Octomap OcTree file";
  std::string line(kFirstLine.size(), '\0');
  stream_.read(line.data(), static_cast<std::streamsize>(line.size()));
  if (line != kFirstLine) {
    throw DataError("{}: not an OctoMap .ot file; make it with the octree stage", path_.string());
  }
  std::string type;
  while (std::getline(stream_, line) && line != "data") {
    if (line.starts_with(kOctreeHashLine)) {
      hash_ = line.substr(kOctreeHashLine.size());
      hashed_from_ = stream_.tellg();
    }
    std::istringstream fields(line);
    std::string key;
    fields >> key;
    if (key == "id") fields >> type;
    if (key == "size") fields >> num_nodes_;
    if (key == "res") fields >> resolution_m_;
  }
  // Fails unless the line before the data ends with a line break.
  if (!stream_ || stream_.eof() || resolution_m_ == 0) Fail("the header ends early or lacks res");
  if (!(resolution_m_ >= kMinLeafEdge_m && resolution_m_ <= kMaxLeafEdge_m)) {
    Fail(fmt::format(
        "field res is {}, not in [{}, {}] m", resolution_m_, kMinLeafEdge_m, kMaxLeafEdge_m));
  }
  if (type != "ColorOcTree" && type != "OcTree") {
    throw DataError("{}: field id is '{}'; ColorOcTree or OcTree is needed", path_.string(), type);
  }
  color_size_ = type == "ColorOcTree" ? 3 : 0;
}

void OctreeReader::CheckData() {
  is_checked_ = true;
  if (!hash_.empty()) {
    if (HashFile(path_, hashed_from_) != hash_) Fail("damaged: its data have another hash");
    return;
  }
  const auto begin = stream_.tellg();
  while (Next()) {
  }
  stream_.clear();
  stream_.seekg(begin);
  num_read_ = 0;
}

// A node is its log-odds, its color if the tree has any, and a byte with one bit per child; then
// its children. Inner nodes hold no information beyond their leaves.
std::optional<PlacedLeaf> OctreeReader::ReadNode(std::uint64_t code, int height) {
  std::array<char, sizeof(float) + 4> bytes{};
  const std::size_t size = sizeof(float) + color_size_ + 1;
  if (!stream_.read(bytes.data(), static_cast<std::streamsize>(size))) Fail("truncated");
  PlacedLeaf leaf{code, 0, {255, 255, 255}, static_cast<std::uint8_t>(height)};
  std::memcpy(&leaf.log_odds, bytes.data(), sizeof(float));
  if (!std::isfinite(leaf.log_odds)) Fail("field log-odds is not finite");
  std::memcpy(leaf.rgb.data(), &bytes[sizeof(float)], color_size_);
  const unsigned children = static_cast<std::uint8_t>(bytes[size - 1]);
  ++num_read_;
  if (children != 0) {
    if (height == 0) Fail("deeper than 16 levels");
    open_.push_back({code, height, children});
    return std::nullopt;
  }
  if (height == kOctreeDepth) Fail("all space is one leaf");
  return leaf;
}

std::optional<PlacedLeaf> OctreeReader::Next() {
  if (!is_checked_) CheckData();
  if (num_read_ == 0 && num_nodes_ > 0) ReadNode(0, kOctreeDepth);
  while (!open_.empty()) {
    Inner& inner = open_.back();
    if (inner.children == 0) {
      open_.pop_back();
      continue;
    }
    const auto child = static_cast<std::uint64_t>(std::countr_zero(inner.children));
    inner.children &= inner.children - 1;
    const int height = inner.height - 1;
    if (auto leaf = ReadNode(inner.code | child << 3 * height, height)) return leaf;
  }
  CheckEnd();
  return std::nullopt;
}

void OctreeReader::CheckEnd() {
  if (num_read_ != num_nodes_ || stream_.peek() != std::ifstream::traits_type::eof()) {
    Fail("field size does not agree with the data");
  }
}

void OctreeReader::Fail(const std::string& problem) const {
  throw DataError("{}: {}; make the octree again", path_.string(), problem);
}

LeafSource LeavesOfFile(const std::filesystem::path& path) {
  return {OctreeReader(path).Resolution_m(),
          [path](const std::function<void(const PlacedLeaf&)>& visit) {
            OctreeReader reader(path);
            while (const auto leaf = reader.Next()) visit(*leaf);
          }};
}

}  // namespace nightmap
