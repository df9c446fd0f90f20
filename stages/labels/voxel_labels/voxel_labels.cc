// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/voxel_labels/voxel_labels.h"

#include <algorithm>
#include <optional>

#include "pipeline/dense/octree_io.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

// How much a keyframe speaks for a class in a voxel.
struct Vote {
  std::uint32_t voxel = 0;  // index among the occupied ones
  std::uint8_t label = 0;
  float weight = 0;
  int num_points = 0;

  bool IsOfSame(const Vote& other) const { return voxel == other.voxel && label == other.label; }
  bool Before(const Vote& other) const {
    return voxel != other.voxel ? voxel < other.voxel : label < other.label;
  }
};

// Adds a vote, to the last one if that is of the same voxel and class.
void Append(const Vote& vote, std::vector<Vote>* votes) {
  if (votes->empty() || !votes->back().IsOfSame(vote)) {
    votes->push_back(vote);
  } else {
    votes->back().weight += vote.weight;
    votes->back().num_points += vote.num_points;
  }
}

struct KeyframeVotes {
  std::vector<Vote> votes;  // by voxel, then by label; one of each
  std::size_t num_points = 0;
};

// Finds voxels by their code. Successive pixels are often in one voxel.
class VoxelFinder {
 public:
  explicit VoxelFinder(const std::vector<std::uint64_t>& codes) : codes_(codes) {}

  std::optional<std::uint32_t> Find(const VoxelKey& key) {
    constexpr int kReach = 1 << (kOctreeDepth - 1);
    if (key.minCoeff() < -kReach || key.maxCoeff() >= kReach) return std::nullopt;
    const std::uint64_t code = MortonCode(key);
    if (code != code_ || !is_asked_) {
      const auto found = std::ranges::lower_bound(codes_, code);
      const bool is_occupied = found != codes_.end() && *found == code;
      found_.reset();
      if (is_occupied) found_ = static_cast<std::uint32_t>(found - codes_.begin());
      code_ = code;
      is_asked_ = true;
    }
    return found_;
  }

 private:
  const std::vector<std::uint64_t>& codes_;
  bool is_asked_ = false;
  std::uint64_t code_ = 0;
  std::optional<std::uint32_t> found_;
};

// Label, confidence and nothing as the channels of a picture, of every `stride`th pixel of every
// `stride`th row: back projection carries the colors of the pixels along to their points.
ColorImage AsColors(const Segmentation& segmentation, int stride) {
  const LabelImage& labels = segmentation.labels;
  ColorImage colors{labels.width, labels.height, 3, {}};
  colors.pixels.resize(3 * labels.pixels.size());
  for (int y = 0; y < labels.height; y += stride) {
    for (int x = 0; x < labels.width; x += stride) {
      const auto i = static_cast<std::size_t>(y * labels.width + x);
      colors.pixels[3 * i] = labels.pixels[i];
      colors.pixels[3 * i + 1] = segmentation.confidences.pixels[i];
    }
  }
  return colors;
}

// Sums equal votes, and divides those of a voxel by the number of its points.
std::vector<Vote> SumVotes(std::vector<Vote> runs) {
  std::ranges::stable_sort(runs, [](const Vote& a, const Vote& b) { return a.Before(b); });
  std::vector<Vote> votes;
  for (const Vote& run : runs) Append(run, &votes);
  for (std::size_t begin = 0; begin < votes.size();) {
    std::size_t end = begin;
    int num_points = 0;
    for (; end < votes.size() && votes[end].voxel == votes[begin].voxel; ++end) {
      num_points += votes[end].num_points;
    }
    for (; begin < end; ++begin) votes[begin].weight /= static_cast<float>(num_points);
  }
  return votes;
}

KeyframeVotes VotesOf(const VoxelLabelsOptions& options,
                      const std::vector<DepthPoint>& points,
                      const Rigid3& map_from_camera,
                      const OccupiedVoxels& occupied) {
  VoxelFinder finder(occupied.codes);
  std::vector<Vote> runs;
  std::size_t num_points = 0;
  for (const DepthPoint& point : points) {
    const Eigen::Vector3d point_in_camera = point.point_in_camera.cast<double>();
    const auto [label, confidence, unused] = point.rgb;
    if (confidence == 0 || point_in_camera.norm() > options.max_range_m) continue;
    const auto voxel =
        finder.Find(VoxelOf(map_from_camera * point_in_camera, occupied.resolution_m));
    if (!voxel) continue;
    Append({*voxel, label, static_cast<float>(confidence) / 255, 1}, &runs);
    ++num_points;
  }
  return {SumVotes(std::move(runs)), num_points};
}

// Votes of all keyframes.
class VoteSums {
 public:
  VoteSums(const std::vector<std::uint64_t>& codes, std::size_t num_classes)
      : table_{codes, num_classes, std::vector<float>(codes.size() * num_classes)},
        num_views_(codes.size()) {}

  void Add(const std::vector<Vote>& votes) {
    for (std::size_t v = 0; v < votes.size(); ++v) {
      if (v == 0 || votes[v].voxel != votes[v - 1].voxel) ++num_views_[votes[v].voxel];
      table_.weights[votes[v].voxel * table_.num_classes + votes[v].label] += votes[v].weight;
    }
  }

  VoteTable& Table() { return table_; }

  // Those of `own`, which are ascending codes of voxels of the table.
  VoxelLabels Voxels(const std::vector<std::uint64_t>& own) const {
    VoxelLabels voxels;
    std::size_t i = 0;
    for (const std::uint64_t code : own) {
      while (table_.codes[i] < code) ++i;
      Append(i, &voxels);
    }
    return voxels;
  }

 private:
  void Append(std::size_t i, VoxelLabels* voxels) const {
    constexpr float kLeastShare = 0.01F;  // less is left out, which says next to nothing
    const float* const weights = table_.weights.data() + i * table_.num_classes;
    const float largest = *std::max_element(weights, weights + table_.num_classes);
    if (largest <= 0) return;
    voxels->keys.push_back(KeyOfMortonCode(table_.codes[i]));
    voxels->num_views.push_back(num_views_[i]);
    for (std::size_t c = 0; c < table_.num_classes; ++c) {
      if (weights[c] < kLeastShare * largest) continue;
      voxels->vote_labels.push_back(static_cast<std::uint8_t>(c));
      voxels->vote_weights.push_back(weights[c]);
    }
    voxels->vote_offsets.push_back(voxels->vote_labels.size());
  }

  VoteTable table_;
  std::vector<std::int32_t> num_views_;
};

}  // namespace

VoxelLabelsOptions::VoxelLabelsOptions() {
  depth_filter.pixel_stride = 3;
  depth_filter.edge_radius_px = 0;
  depth_filter.max_incidence_rad = 1.5707963;
}

LabelLoader LoaderOf(const FrameLabels& labels, const std::vector<RgbdCamera>& cameras) {
  return [&](const Keyframe& keyframe) {
    return labels.Of(keyframe.frame,
                     cameras[static_cast<std::size_t>(keyframe.frame.camera_idx)].color);
  };
}

VoxelLabelsResult RunVoxelLabels(const VoxelLabelsOptions& options,
                                 const KeyframeSource& source,
                                 const LabelLoader& labels,
                                 const std::vector<std::string>& classes,
                                 const OccupiedVoxels& occupied,
                                 Progress& progress,
                                 int num_threads) {
  KeyframeSource labelled = source;
  labelled.load = [&](const Keyframe& keyframe) {
    return RgbdImages{AsColors(labels(keyframe), options.depth_filter.pixel_stride),
                      source.load_depth(keyframe)};
  };
  const auto ray_tables = MakeRayTables(source.cameras, num_threads);
  VoteSums sums(occupied.codes, classes.size());
  VoxelLabelsResult result;
  result.skipped = FuseKeyframes<KeyframeVotes>(
      labelled,
      progress,
      num_threads,
      [&](const Keyframe& keyframe, const RgbdImages& images) {
        const auto camera = static_cast<std::size_t>(keyframe.frame.camera_idx);
        const auto points = BackProjectDepth(images.depth,
                                             images.color,
                                             ray_tables[camera],
                                             source.cameras[camera],
                                             options.max_range_m,
                                             options.depth_filter);
        return VotesOf(options, points, keyframe.map_from_camera, occupied);
      },
      [&](KeyframeVotes&& votes) {
        result.num_points += votes.num_points;
        sums.Add(votes.votes);
      });
  SpreadVotes(options.spread, num_threads, &sums.Table());
  result.voxels = sums.Voxels(occupied.own);
  result.voxels.resolution_m = occupied.resolution_m;
  if (result.voxels.Size() > 0) result.voxels.classes = classes;
  return result;
}

nlohmann::json Summarize(const KeyframeSource& source,
                         const OccupiedVoxels& occupied,
                         const VoxelLabelsResult& result) {
  return {{"num_keyframes_listed", source.keyframes.size()},
          {"num_points", result.num_points},
          {"num_occupied_voxels", occupied.own.size()},
          {"num_labelled_voxels", result.voxels.Size()}};
}

}  // namespace nightmap
