// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/voxel_labels_io.h"

#include <algorithm>

#include "pipeline/io/hdf5_table.h"
#include "pipeline/io/labels_io.h"

namespace nightmap {
namespace {

constexpr char kVoxelLabelsFormat[] = "nightmap voxel labels";
constexpr int kVoxelLabelsVersion = 1;
constexpr int kKeyReach = 1 << 15;  // of an octree of depth 16

bool InReach(std::int32_t coordinate) { return coordinate >= -kKeyReach && coordinate < kKeyReach; }

constexpr auto kKeys = Hdf5Table<VoxelKey>(
    Hdf5Column("key", kItself)
        .Elements(InReach)
        .Pairs([](const VoxelKey& a, const VoxelKey& b) { return MortonCode(a) < MortonCode(b); },
               "is not in Morton order"));
constexpr auto kNumViews =
    Hdf5Table<std::int32_t>(Hdf5Column("num_views", kItself).Elements(kNotNegative));
constexpr auto kVoteWeights =
    Hdf5Table<float>(Hdf5Column("vote_weight", kItself).Elements(kPositive));

void ReadVotes(const Hdf5Reader& file, VoxelLabels* voxels) {
  voxels->vote_labels = file.ReadList<std::uint8_t>("vote_label");
  voxels->vote_weights = kVoteWeights.Read(file);
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
  file.Demand(voxels->vote_weights.size() == num_votes, "vote_weight");
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
  Hdf5Writer file(path,
                  kVoxelLabelsFormat,
                  kVoxelLabelsVersion,
                  config,
                  "voxels of resolution_m in the map frame; weights are sums of probabilities");
  WriteClassNames(voxels.classes, &file);
  file.WriteList("resolution_m", std::vector<double>{voxels.resolution_m});
  kKeys.Write(voxels.keys, &file);
  kNumViews.Write(voxels.num_views, &file);
  file.WriteList("vote_offset",
                 std::vector<std::int64_t>(voxels.vote_offsets.begin(), voxels.vote_offsets.end()));
  file.WriteList("vote_label", voxels.vote_labels);
  kVoteWeights.Write(voxels.vote_weights, &file);
  file.Close();
}

VoxelLabels ReadVoxelLabels(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kVoxelLabelsFormat, kVoxelLabelsVersion);
  VoxelLabels voxels;
  voxels.resolution_m = file.ReadOne<double>("resolution_m");
  file.Demand(voxels.resolution_m > 0, "resolution_m");
  voxels.classes = ReadClassNames(file);
  voxels.keys = kKeys.Read(file);
  voxels.num_views = kNumViews.Read(file);
  file.Demand(voxels.num_views.size() == voxels.Size(), "num_views");
  ReadVotes(file, &voxels);
  return voxels;
}

}  // namespace nightmap
