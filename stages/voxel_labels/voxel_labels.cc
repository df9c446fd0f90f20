// SPDX-License-Identifier: Apache-2.0
#include "stages/voxel_labels/voxel_labels.h"

#include <algorithm>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/dense/octree_reader.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

// How much one keyframe, or all of them, speak for a class in a voxel.
struct Vote {
  std::uint32_t voxel = 0;  // index among the occupied ones
  std::uint8_t label = 0;
  float weight = 0;

  bool Before(const Vote& other) const {
    return voxel != other.voxel ? voxel < other.voxel : label < other.label;
  }
};

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

// Label, confidence and nothing as the channels of a picture: back projection carries the colors of
// the pixels along to their points.
ColorImage AsColors(const Segmentation& segmentation) {
  const LabelImage& labels = segmentation.labels;
  ColorImage colors{labels.width, labels.height, 3, {}};
  colors.pixels.resize(3 * labels.pixels.size());
  for (std::size_t i = 0; i < labels.pixels.size(); ++i) {
    colors.pixels[3 * i] = labels.pixels[i];
    colors.pixels[3 * i + 1] = segmentation.confidences.pixels[i];
  }
  return colors;
}

// Sums equal votes, and divides those of a voxel by the number of its points.
std::vector<Vote> SumVotes(std::vector<Vote>& points) {
  std::ranges::stable_sort(points, [](const Vote& a, const Vote& b) { return a.Before(b); });
  std::vector<Vote> votes;
  for (std::size_t begin = 0; begin < points.size();) {
    std::size_t end = begin;
    const std::size_t first = votes.size();
    for (; end < points.size() && points[end].voxel == points[begin].voxel; ++end) {
      if (votes.size() == first || votes.back().label != points[end].label) {
        votes.push_back({points[end].voxel, points[end].label, 0});
      }
      votes.back().weight += points[end].weight;
    }
    for (std::size_t v = first; v < votes.size(); ++v) {
      votes[v].weight /= static_cast<float>(end - begin);
    }
    begin = end;
  }
  return votes;
}

KeyframeVotes VotesOf(const VoxelLabelsOptions& options,
                      const std::vector<DepthPoint>& points,
                      const Rigid3& map_from_camera,
                      const OccupiedVoxels& occupied) {
  VoxelFinder finder(occupied.codes);
  std::vector<Vote> votes;
  for (const DepthPoint& point : points) {
    const Eigen::Vector3d point_in_camera = point.point_in_camera.cast<double>();
    const auto [label, confidence, unused] = point.rgb;
    if (confidence == 0 || point_in_camera.norm() > options.max_range_m) continue;
    const auto voxel =
        finder.Find(VoxelOf(map_from_camera * point_in_camera, occupied.resolution_m));
    if (voxel) votes.push_back({*voxel, label, static_cast<float>(confidence) / 255});
  }
  const std::size_t num_points = votes.size();
  return {SumVotes(votes), num_points};
}

// Votes of all keyframes.
class VoteSums {
 public:
  explicit VoteSums(std::size_t num_voxels) : sums_(num_voxels), num_views_(num_voxels) {}

  void Add(const std::vector<Vote>& votes) {
    for (std::size_t v = 0; v < votes.size(); ++v) {
      if (v == 0 || votes[v].voxel != votes[v - 1].voxel) ++num_views_[votes[v].voxel];
      auto& sums = sums_[votes[v].voxel];
      const auto place = std::ranges::lower_bound(sums, votes[v].label, {}, &LabelSum::label);
      if (place != sums.end() && place->label == votes[v].label) {
        place->weight += votes[v].weight;
      } else {
        sums.insert(place, {votes[v].label, votes[v].weight});
      }
    }
  }

  VoxelLabels Voxels(const OccupiedVoxels& occupied) const {
    VoxelLabels voxels;
    voxels.resolution_m = occupied.resolution_m;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      if (sums_[i].empty()) continue;
      voxels.keys.push_back(KeyOfMortonCode(occupied.codes[i]));
      voxels.num_views.push_back(num_views_[i]);
      for (const LabelSum& sum : sums_[i]) {
        voxels.vote_labels.push_back(sum.label);
        voxels.vote_weights.push_back(sum.weight);
      }
      voxels.vote_offsets.push_back(voxels.vote_labels.size());
    }
    return voxels;
  }

 private:
  struct LabelSum {
    std::uint8_t label = 0;
    float weight = 0;
  };
  std::vector<std::vector<LabelSum>> sums_;  // by voxel; labels ascend
  std::vector<std::int32_t> num_views_;
};

}  // namespace

VoxelLabelsOptions::VoxelLabelsOptions() { depth_filter.pixel_stride = 4; }

void VoxelLabelsOptions::Register(OptionList& list) {
  list.Add("keyframe_stride", &keyframe_stride, Range(1, 1000), "uses every Nth keyframe");
  list.Add("max_range_m",
           &max_range_m,
           Range(0.1, 100.0),
           "pixels beyond this range do not vote for a label");
  depth_filter.Register(list);
}

OccupiedVoxels ReadOccupiedVoxels(const std::filesystem::path& octree) {
  OctreeReader reader(octree);
  OccupiedVoxels occupied{reader.Resolution_m(), {}};
  while (const auto leaf = reader.Next()) {
    if (leaf->log_odds < 0) continue;
    const std::uint64_t num_voxels = std::uint64_t{1} << 3 * leaf->height;
    for (std::uint64_t i = 0; i < num_voxels; ++i) occupied.codes.push_back(leaf->code + i);
  }
  return occupied;
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
    return RgbdImages{AsColors(labels(keyframe)), source.load_depth(keyframe)};
  };
  const auto ray_tables = MakeRayTables(source.cameras, num_threads);
  VoteSums sums(occupied.codes.size());
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
  result.voxels = sums.Voxels(occupied);
  result.voxels.classes = classes;
  return result;
}

}  // namespace nightmap
