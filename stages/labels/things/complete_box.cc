// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/complete_box.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace nightmap {
namespace {

constexpr double kMaxStrayShare = 0.1;   // of a layer that may be seen free, or be another's
constexpr double kBeside_m = 0.5;        // how far beside and above a thing its wall is looked for
constexpr double kMaxTop_m = 1.2;        // height of a top above its ground
constexpr double kGroundAround_m = 0.3;  // how far around a thing its ground is looked for
constexpr double kMinGroundShare = 0.1;  // of the places around that show the same ground
constexpr int kMinWallVoxels = 3;        // above each other; a floor or a ceiling has fewer
constexpr double kMinWallShare = 0.5;    // of the columns beside or above a thing

enum class Content { kUnknown, kFree, kOwn, kThing, kStructure };

enum class Layer { kHidden, kSeen, kBlocked };

// Centres of the voxels that fill [min, max] evenly; one at least.
std::vector<double> Steps(double min, double max, double resolution_m) {
  const int count = std::max(1, static_cast<int>(std::lround((max - min) / resolution_m)));
  std::vector<double> steps;
  for (int i = 0; i < count; ++i) steps.push_back(min + (i + 0.5) * (max - min) / count);
  return steps;
}

class BoxCompletion {
 public:
  BoxCompletion(const CompletionOptions& options,
                const LabelledSpace& space,
                const std::vector<Eigen::Vector3d>& points_in_map,
                UprightBox* box)
      : options_(options), space_(space), resolution_m_(space.Resolution_m()), box_(*box) {
    for (const Eigen::Vector3d& point : points_in_map) {
      codes_.push_back(MortonCode(VoxelOf(point, resolution_m_)));
    }
    std::ranges::sort(codes_);
    num_layers_ = static_cast<int>(options.max_hidden_m / resolution_m_ + 1e-9);
    num_layers_ = options.top_layer ? static_cast<int>(kMaxTop_m / resolution_m_) : num_layers_;
  }

  void LowerToGround(const std::vector<Eigen::Vector3d>& points_in_map) {
    const int layer = options_.top_layer ? GroundLayerOfTop() : GroundLayer();
    if (layer < 1 || (!options_.top_layer && IsSeenFreeBelow(points_in_map, layer))) return;
    box_.extent.min().z() -= layer * resolution_m_;
  }

  // The thinner direction first: a front seen alone has its hidden depth along it, and the other
  // sides are known only as far as the depth is.
  void MoveSides() {
    const Eigen::Vector3d size_m = box_.extent.sizes();
    const int first = size_m.x() <= size_m.y() ? 0 : 1;
    for (const int axis : {first, 1 - first}) {
      const double back_m = HiddenDepth_m(axis, -1);
      const double ahead_m = HiddenDepth_m(axis, 1);
      box_.extent.min()[axis] -= back_m;
      box_.extent.max()[axis] += ahead_m;
    }
  }

 private:
  Content At(const Eigen::Vector3d& point_in_box) const {
    const VoxelKey key = VoxelOf(box_.ToMap(point_in_box), resolution_m_);
    const VoxelState state = space_.At(key);
    if (state == VoxelState::kUnknown) return Content::kUnknown;
    if (state == VoxelState::kFree) return Content::kFree;
    const auto label = space_.LabelAt(key);
    if (label == options_.label && IsOwn(key)) return Content::kOwn;
    return label && options_.is_thing_class[*label] ? Content::kThing : Content::kStructure;
  }

  bool IsOwn(const VoxelKey& key) const {
    return !options_.is_whole || std::ranges::binary_search(codes_, MortonCode(key));
  }

  // Layers below the box at which most places around show something occupied; 0: none is lower.
  int GroundLayer() const {
    const auto& [min, max] = std::pair(box_.extent.min(), box_.extent.max());
    std::vector<int> counts(static_cast<std::size_t>(num_layers_) + 1);
    int num_places = 0;
    for (const double x :
         Steps(min.x() - kGroundAround_m, max.x() + kGroundAround_m, resolution_m_)) {
      for (const double y :
           Steps(min.y() - kGroundAround_m, max.y() + kGroundAround_m, resolution_m_)) {
        ++num_places;
        for (int layer = 0; layer <= num_layers_; ++layer) {
          const Content content = At({x, y, min.z() - layer * resolution_m_});
          if (content != Content::kThing && content != Content::kStructure) continue;
          ++counts[static_cast<std::size_t>(layer)];
          break;
        }
      }
    }
    const auto most = std::ranges::max_element(counts);
    return *most < kMinGroundShare * num_places ? 0 : static_cast<int>(most - counts.begin());
  }

  // The lowest layer at which floors and walls around show: they hide it under a table, and other
  // furniture hides it around.
  int GroundLayerOfTop() const {
    const auto& [min, max] = std::pair(box_.extent.min(), box_.extent.max());
    const auto xs = Steps(min.x() - kGroundAround_m, max.x() + kGroundAround_m, resolution_m_);
    const auto ys = Steps(min.y() - kGroundAround_m, max.y() + kGroundAround_m, resolution_m_);
    for (int layer = static_cast<int>(kMaxTop_m / resolution_m_); layer > 0; --layer) {
      std::size_t num_ground = 0;
      for (const double x : xs) {
        for (const double y : ys) {
          num_ground += At({x, y, min.z() - layer * resolution_m_}) == Content::kStructure;
        }
      }
      if (static_cast<double>(num_ground) >=
          kMinGroundShare * static_cast<double>(xs.size() * ys.size()))
        return layer;
    }
    return 0;
  }

  // Whether free space was seen between the thing's lowest voxels and the ground.
  bool IsSeenFreeBelow(const std::vector<Eigen::Vector3d>& points_in_map, int ground_layer) const {
    const double bottom_m = box_.extent.min().z();
    std::set<std::pair<double, double>> feet;
    for (const Eigen::Vector3d& point : points_in_map) {
      if (point.z() < bottom_m + 1.5 * resolution_m_) feet.insert({point.x(), point.y()});
    }
    int num_free = 0, num_between = 0;
    for (const auto& [x, y] : feet) {
      for (int layer = 1; layer < ground_layer; ++layer) {
        const VoxelKey key = VoxelOf({x, y, bottom_m - layer * resolution_m_}, resolution_m_);
        num_free += space_.At(key) == VoxelState::kFree;
        ++num_between;
      }
    }
    return 2 * num_free > num_between;
  }

  // By how much to move the side of the box at the upper (sign 1) or lower end (-1) of an axis.
  double HiddenDepth_m(int axis, int sign) const {
    const double side_m = sign > 0 ? box_.extent.max()[axis] : box_.extent.min()[axis];
    for (int layer = 0; layer < num_layers_; ++layer) {
      const Layer found = LayerAt(axis, side_m + sign * (layer + 1) * resolution_m_);
      if (found == Layer::kBlocked) return std::min(layer + 0.5, 1.0 * num_layers_) * resolution_m_;
      if (found == Layer::kSeen) return layer * resolution_m_ / 2;
    }
    return num_layers_ * resolution_m_ / 2;
  }

  Layer LayerAt(int axis, double at_m) const {
    const std::vector<double> heights = HeightsOfSide();
    int num_free = 0, num_others = 0, num_samples = 0;
    for (const double across_m : Across(axis, 0, 0)) {
      for (const double z_m : heights) {
        const Content content = At(PointIn(axis, at_m, across_m, z_m));
        num_free += content == Content::kFree;
        num_others +=
            content == Content::kStructure || (content == Content::kThing && !options_.top_layer);
        ++num_samples;
      }
    }
    if (num_others > kMaxStrayShare * num_samples || HasWall(axis, at_m)) return Layer::kBlocked;
    return num_free > kMaxStrayShare * num_samples ? Layer::kSeen : Layer::kHidden;
  }

  // Above the ground's voxels; of a top on legs, that of the top.
  std::vector<double> HeightsOfSide() const {
    if (options_.top_layer) return {(*options_.top_layer + 0.5) * resolution_m_};
    const double top_m = box_.extent.max().z();
    const double low_m = box_.extent.min().z() + 2 * resolution_m_;
    return Steps(std::min(low_m, top_m - resolution_m_ / 2), top_m, resolution_m_);
  }

  bool HasWall(int axis, double at_m) const {
    const double low_m = box_.extent.min().z() + 2 * resolution_m_;
    const double top_m = box_.extent.max().z();
    const double width_m = box_.extent.sizes()[1 - axis];
    return IsWall(axis, at_m, Across(axis, kBeside_m, -width_m), low_m, top_m + kBeside_m) ||
           IsWall(axis, at_m, Across(axis, -width_m, kBeside_m), low_m, top_m + kBeside_m) ||
           IsWall(axis, at_m, Across(axis, 0, 0), top_m + resolution_m_, top_m + kBeside_m);
  }

  // Whether most of the columns hold a piece of what is no thing.
  bool IsWall(int axis,
              double at_m,
              const std::vector<double>& columns,
              double low_m,
              double high_m) const {
    int num_walls = 0;
    for (const double across_m : columns) {
      int num_voxels = 0;
      for (const double z_m : Steps(low_m, high_m, resolution_m_)) {
        num_voxels += At(PointIn(axis, at_m, across_m, z_m)) == Content::kStructure;
      }
      num_walls += num_voxels >= kMinWallVoxels;
    }
    return num_walls >= kMinWallShare * static_cast<double>(columns.size());
  }

  // Places across a side, from `before_m` before the box to `behind_m` behind it.
  std::vector<double> Across(int axis, double before_m, double behind_m) const {
    return Steps(box_.extent.min()[1 - axis] - before_m,
                 box_.extent.max()[1 - axis] + behind_m,
                 resolution_m_);
  }

  static Eigen::Vector3d PointIn(int axis, double at_m, double across_m, double z_m) {
    Eigen::Vector3d point(across_m, across_m, z_m);
    point[axis] = at_m;
    return point;
  }

  const CompletionOptions& options_;
  const LabelledSpace& space_;
  double resolution_m_;
  int num_layers_;
  UprightBox& box_;
  std::vector<std::uint64_t> codes_;  // of the thing's voxels, ascending
};

}  // namespace

void CompleteBox(const CompletionOptions& options,
                 const LabelledSpace& space,
                 const std::vector<Eigen::Vector3d>& points_in_map,
                 UprightBox* box) {
  BoxCompletion completion(options, space, points_in_map, box);
  completion.LowerToGround(points_in_map);
  completion.MoveSides();
}

}  // namespace nightmap
