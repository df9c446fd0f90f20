// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/join_labels/join_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "pipeline/base/input_error.h"
#include "pipeline/dense/octree_writer.h"
#include "stages/labels/join_labels/class_colors.h"

namespace nightmap {
namespace {

using LabelledOctree = OctreeWriter<NodeEncoder<ClassColors>>;

// A voxel of a part.
struct Place {
  std::uint64_t code = 0;
  std::size_t part = 0;
  std::size_t voxel = 0;
};

std::vector<Place> SortedPlaces(const std::vector<VoxelLabels>& parts) {
  std::vector<Place> places;
  for (std::size_t part = 0; part < parts.size(); ++part) {
    for (std::size_t i = 0; i < parts[part].Size(); ++i) {
      places.push_back({MortonCode(parts[part].keys[i]), part, i});
    }
  }
  std::ranges::sort(places, {}, &Place::code);
  const auto twice = std::ranges::adjacent_find(places, {}, &Place::code);
  if (twice == places.end()) return places;
  const Eigen::Vector3d centre =
      VoxelCentre(KeyOfMortonCode(twice->code), parts[twice->part].resolution_m);
  throw InputError({{"tile_labels", twice->part}, {"tile_labels", std::next(twice)->part}},
                   "both label the voxel at ({}, {}, {})",
                   centre.x(),
                   centre.y(),
                   centre.z());
}

// Parts without voxels may have none. Throws InputError when parts differ.
std::vector<std::string> CommonClasses(const std::vector<VoxelLabels>& parts) {
  std::size_t first = 0;  // with classes
  while (first + 1 < parts.size() && parts[first].classes.empty()) ++first;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool is_alike = parts[i].classes.empty() || parts[i].classes == parts[first].classes;
    if (is_alike && parts[i].resolution_m == parts[0].resolution_m) continue;
    throw InputError({{"tile_labels", is_alike ? 0 : first}, {"tile_labels", i}},
                     "they differ in resolution or classes");
  }
  return parts[first].classes;
}

// Adds an occupied leaf as cubes that hold no label, and voxels that have one. How many these are
// depends on the labels, not on the size of the leaf.
void AddOccupied(const PlacedLeaf& leaf, const VoxelLabels& voxels, LabelledOctree* writer) {
  const auto begin = std::ranges::lower_bound(voxels.keys, leaf.code, {}, MortonCode);
  const std::uint64_t end = leaf.code + (std::uint64_t{1} << 3 * leaf.height);
  if (leaf.height == 0 || begin == voxels.keys.end() || MortonCode(*begin) >= end) {
    return writer->Add(leaf);
  }
  PlacedLeaf child = leaf;
  --child.height;
  for (; child.code < end; child.code += std::uint64_t{1} << 3 * child.height) {
    AddOccupied(child, voxels, writer);
  }
}

std::string Hex(const Rgb& color) {
  return fmt::format("#{:02x}{:02x}{:02x}", color[0], color[1], color[2]);
}

}  // namespace

VoxelLabels JoinVoxelLabels(const std::vector<VoxelLabels>& parts) {
  VoxelLabels joined;
  joined.classes = CommonClasses(parts);
  joined.resolution_m = parts.at(0).resolution_m;
  for (const Place& place : SortedPlaces(parts)) {
    const VoxelLabels& part = parts[place.part];
    joined.keys.push_back(part.keys[place.voxel]);
    joined.num_views.push_back(part.num_views[place.voxel]);
    for (std::size_t v = part.vote_offsets[place.voxel]; v < part.vote_offsets[place.voxel + 1];
         ++v) {
      joined.vote_labels.push_back(part.vote_labels[v]);
      joined.vote_weights.push_back(part.vote_weights[v]);
    }
    joined.vote_offsets.push_back(joined.vote_labels.size());
  }
  return joined;
}

void WriteLabelledOctree(const std::filesystem::path& path,
                         const LeafSource& leaves,
                         const VoxelLabels& voxels,
                         const std::vector<Rgb>& palette) {
  LabelledOctree writer(path, leaves.resolution_m, NodeEncoder(ClassColors(voxels, palette)));
  leaves.visit([&](const PlacedLeaf& leaf) {
    leaf.Occupied() ? AddOccupied(leaf, voxels, &writer) : writer.Add(leaf);
  });
  writer.Close();
}

LabelAt::LabelAt(const VoxelLabels& voxels) : voxels_(voxels) {
  codes_.reserve(voxels.Size());
  for (const VoxelKey& key : voxels.keys) codes_.push_back(MortonCode(key));
}

std::uint8_t LabelAt::operator()(const Eigen::Vector3d& point_in_map) const {
  const std::uint64_t code = MortonCode(VoxelOf(point_in_map, voxels_.resolution_m));
  const auto found = std::ranges::lower_bound(codes_, code);
  if (found == codes_.end() || *found != code) return 0;
  return LabelOf(voxels_, static_cast<std::size_t>(found - codes_.begin())).label;
}

std::vector<std::size_t> CountClasses(const VoxelLabels& voxels) {
  std::vector<std::size_t> counts(voxels.classes.size());
  for (std::size_t i = 0; i < voxels.Size(); ++i) ++counts[LabelOf(voxels, i).label];
  return counts;
}

std::string LegendJson(const VoxelLabels& voxels, const std::vector<Rgb>& palette) {
  const auto counts = CountClasses(voxels);
  nlohmann::ordered_json json;
  json["format"] = "nightmap_legend";
  json["version"] = 1;
  json["resolution_m"] = voxels.resolution_m;
  json["classes"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < voxels.classes.size(); ++i) {
    json["classes"].push_back({{"label", i},
                               {"name", voxels.classes[i]},
                               {"color", Hex(palette[i])},
                               {"num_voxels", counts[i]}});
  }
  return json.dump(1) + "\n";
}

}  // namespace nightmap
