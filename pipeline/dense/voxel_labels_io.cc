// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/voxel_labels_io.h"

#include <algorithm>

#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/labels_io.h"

namespace nightmap {
namespace {

constexpr char kVoxelLabelsFormat[] = "nightmap voxel labels";
constexpr int kVoxelLabelsVersion = 1;
constexpr int kKeyReach = 1 << 15;  // of an octree of depth 16

bool InReach(std::int32_t coordinate) { return coordinate >= -kKeyReach && coordinate < kKeyReach; }

void ReadKeys(const Hdf5Reader& file, VoxelLabels* voxels) {
  const auto keys = file.Read<std::int32_t>("key", 3);
  file.Demand(std::ranges::all_of(keys.values, InReach), "key");
  voxels->keys.reserve(keys.rows);
  for (std::size_t i = 0; i < keys.rows; ++i) {
    const std::int32_t* key = &keys.values[3 * i];
    voxels->keys.emplace_back(key[0], key[1], key[2]);
  }
  const auto does_not_ascend = [](const VoxelKey& a, const VoxelKey& b) {
    return MortonCode(a) >= MortonCode(b);
  };
  file.Demand(std::ranges::adjacent_find(voxels->keys, does_not_ascend) == voxels->keys.end(),
              "key",
              "is not in Morton order");
}

void ReadVotes(const Hdf5Reader& file, VoxelLabels* voxels) {
  voxels->vote_labels = file.ReadList<std::uint8_t>("vote_label");
  voxels->vote_weights = file.ReadList<float>("vote_weight");
  const std::size_t num_votes = voxels->vote_labels.size();
  voxels->vote_offsets = file.ReadOffsets("vote_offset", voxels->Size(), num_votes);
  for (std::size_t i = 0; i < voxels->Size(); ++i) {
    const auto begin = voxels->vote_labels.begin();
    const auto first = static_cast<std::ptrdiff_t>(voxels->vote_offsets[i]);
    const auto last = static_cast<std::ptrdiff_t>(voxels->vote_offsets[i + 1]);
    file.Demand(first < last, "vote_offset", "has a voxel without a vote");
    file.Demand(
        std::adjacent_find(begin + first, begin + last, std::greater_equal<>()) == begin + last,
        "vote_label",
        "does not ascend in a voxel");
  }
  file.Demand(std::ranges::all_of(voxels->vote_labels,
                                  [&](std::uint8_t l) { return l < voxels->classes.size(); }),
              "vote_label",
              "has a label of no class");
  file.Demand(voxels->vote_weights.size() == num_votes &&
                  std::ranges::all_of(voxels->vote_weights, [](float w) { return w > 0; }),
              "vote_weight");
}

}  // namespace

VoxelLabel LabelOf(const VoxelLabels& voxels, std::size_t i) {
  std::size_t best = voxels.vote_offsets[i];
  double sum = 0;
  for (std::size_t v = voxels.vote_offsets[i]; v < voxels.vote_offsets[i + 1]; ++v) {
    sum += voxels.vote_weights[v];
    if (voxels.vote_weights[v] > voxels.vote_weights[best]) best = v;
  }
  return {voxels.vote_labels[best], voxels.vote_weights[best] / sum};
}

void WriteVoxelLabels(const std::filesystem::path& path,
                      const VoxelLabels& voxels,
                      const std::string& config) {
  Array<std::int32_t> keys{voxels.Size(), 3, {}};
  keys.values.reserve(3 * voxels.Size());
  for (const VoxelKey& key : voxels.keys) {
    keys.values.insert(keys.values.end(), {key.x(), key.y(), key.z()});
  }
  Hdf5Writer file(path,
                  kVoxelLabelsFormat,
                  kVoxelLabelsVersion,
                  config,
                  "voxels of resolution_m in the map frame; weights are sums of probabilities");
  WriteClassNames(voxels.classes, &file);
  file.WriteList("resolution_m", std::vector<double>{voxels.resolution_m});
  file.Write("key", keys);
  file.WriteList("num_views", voxels.num_views);
  file.WriteList("vote_offset",
                 std::vector<std::int64_t>(voxels.vote_offsets.begin(), voxels.vote_offsets.end()));
  file.WriteList("vote_label", voxels.vote_labels);
  file.WriteList("vote_weight", voxels.vote_weights);
  file.Close();
}

VoxelLabels ReadVoxelLabels(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kVoxelLabelsFormat, kVoxelLabelsVersion);
  VoxelLabels voxels;
  const auto resolution_m = file.ReadList<double>("resolution_m");
  file.Demand(resolution_m.size() == 1 && resolution_m[0] > 0, "resolution_m");
  voxels.resolution_m = resolution_m[0];
  voxels.classes = ReadClassNames(file);
  ReadKeys(file, &voxels);
  voxels.num_views = file.ReadList<std::int32_t>("num_views");
  file.Demand(voxels.num_views.size() == voxels.Size() &&
                  std::ranges::all_of(voxels.num_views, [](std::int32_t n) { return n >= 0; }),
              "num_views");
  ReadVotes(file, &voxels);
  return voxels;
}

}  // namespace nightmap
