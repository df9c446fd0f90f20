// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/things.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "stages/labels/things/clusters.h"
#include "stages/labels/things/complete_box.h"
#include "stages/labels/things/join_parts.h"
#include "stages/labels/things/scraps.h"
#include "stages/labels/things/split_steps.h"
#include "stages/labels/things/tops.h"
#include "stages/labels/things/views.h"

namespace nightmap {
namespace {

using Points = std::vector<Eigen::Vector3d>;

double Rounded(double value, double steps_per_unit) {
  return std::round(value * steps_per_unit) / steps_per_unit + 0.0;  // + 0.0: no minus before zero
}

void CheckNames(const std::vector<std::string>& names, const std::vector<std::string>& classes) {
  if (classes.empty()) return;  // no voxel has a label
  for (const std::string& name : names) {
    if (std::ranges::find(classes, name) != classes.end()) continue;
    throw UsageError(
        "things.classes: the model has no class '{}'; it has {}", name, fmt::join(classes, ", "));
  }
}

std::vector<std::uint8_t> ListedLabels(const ThingsOptions& options,
                                       const std::vector<std::string>& classes) {
  CheckNames(options.classes, classes);
  const auto has = [](const std::vector<std::string>& names, const std::string& name) {
    return std::ranges::find(names, name) != names.end();
  };
  std::vector<std::uint8_t> labels;
  for (std::size_t label = 0; label < classes.size(); ++label) {
    const bool is_listed = options.classes.empty() ? !has(options.leave_out, classes[label])
                                                   : has(options.classes, classes[label]);
    if (is_listed) labels.push_back(static_cast<std::uint8_t>(label));
  }
  return labels;
}

// Turns the frame so that its x axis points out of the side that faces `direction_in_map`, and puts
// its origin into the middle of the box.
void SetFrame(const UprightBox& box, const Eigen::Vector2d& direction_in_map, Thing* thing) {
  const Rigid2& map_from_box = box.map_from_box;
  const Eigen::Vector2d seen_from =
      Eigen::Rotation2Dd(-map_from_box.heading_rad) * direction_in_map;
  const bool along_y = std::abs(seen_from.y()) > std::abs(seen_from.x());
  const double turn_deg = along_y ? (seen_from.y() > 0 ? 90 : -90) : (seen_from.x() < 0 ? 180 : 0);
  const double heading_rad =
      WrapAngle_rad(map_from_box.heading_rad + turn_deg * std::numbers::pi / 180);
  const Eigen::Vector2d centre = box.Centre();
  thing->map_from_thing = {Rounded(heading_rad, 1e4),
                           {Rounded(centre.x(), 1000), Rounded(centre.y(), 1000)}};
  Eigen::Vector3d size_m = box.extent.sizes();
  if (along_y) std::swap(size_m.x(), size_m.y());
  for (int axis = 0; axis < 3; ++axis) thing->size_m[axis] = Rounded(size_m[axis], 1000);
  thing->bottom_m = Rounded(box.extent.min().z(), 1000);
}

// Shared data of all things of a run.
class ThingMaker {
 public:
  ThingMaker(const ThingsOptions& options,
             const ThingsInputs& inputs,
             const std::vector<std::uint8_t>& labels)
      : options_(options), inputs_(inputs), space_(inputs.leaves, inputs.voxels) {
    completion_.max_hidden_m = options.max_hidden_m;
    for (const std::uint8_t label : labels) completion_.is_thing_class[label] = true;
  }

  // is_whole: no other cluster is a part of the same thing.
  UprightBox BoxOf(const Cluster& cluster, bool is_whole) const {
    const Points points = PointsOf(cluster);
    UprightBox box = FitBox(points, inputs_.voxels.resolution_m);
    CompletionOptions of_class = completion_;
    of_class.label = cluster.label;
    of_class.is_whole = is_whole;
    of_class.top_layer = TopLayer(inputs_.voxels, cluster, kTopShare);
    CompleteBox(of_class, space_, points, &box);
    return box;
  }

  const LabelledSpace& Space() const { return space_; }

  bool IsThing(const Cluster& cluster) const {
    return !IsStain(inputs_.voxels, space_, completion_.is_thing_class, cluster) &&
           !IsLeg(inputs_.voxels, cluster);
  }

  Thing Make(const Cluster& cluster) const {
    const ThingViews views = FindViews(
        space_, PointsOf(cluster), inputs_.keyframes, inputs_.cameras, options_.max_range_m);
    Thing thing;
    thing.class_name = inputs_.voxels.classes[cluster.label];
    SetFrame(BoxOf(cluster, true), views.direction_in_map, &thing);
    thing.num_views = views.num_views;
    thing.best_view = views.best;
    thing.confidence = Rounded(cluster.mean_share, 1e4);
    return thing;
  }

 private:
  Points PointsOf(const Cluster& cluster) const {
    Points points;
    for (const std::size_t i : cluster.voxels) {
      points.push_back(VoxelCentre(inputs_.voxels.keys[i], inputs_.voxels.resolution_m));
    }
    return points;
  }

  const ThingsOptions& options_;
  const ThingsInputs& inputs_;
  LabelledSpace space_;
  CompletionOptions completion_;
};

std::vector<Cluster> SplitAll(const VoxelLabels& voxels,
                              const LabelledSpace& space,
                              const std::vector<Cluster>& clusters) {
  std::vector<Cluster> parts;
  for (const Cluster& cluster : clusters) {
    for (Cluster& part : SplitSteps(voxels, space, cluster)) parts.push_back(std::move(part));
  }
  return parts;
}

// By the text of the name, so that classes "arm chair" and "arm_chair" have no thing of one name.
void NumberThings(std::vector<Thing>* things) {
  std::map<std::string, int> counts;
  for (Thing& thing : *things) {
    std::string name = thing.class_name;
    std::ranges::replace(name, ' ', '_');
    thing.name = fmt::format("{}_{}", name, ++counts[name]);
  }
}

}  // namespace

std::vector<Thing> RunThings(const ThingsOptions& options,
                             const ThingsInputs& inputs,
                             Progress& progress,
                             int num_threads) {
  if (std::abs(inputs.leaves.resolution_m / inputs.voxels.resolution_m - 1) > 1e-9) {
    throw InputError({{"octree"}, {"voxels"}},
                     "voxels of {} m and of {} m",
                     inputs.leaves.resolution_m,
                     inputs.voxels.resolution_m);
  }
  const auto labels = ListedLabels(options, inputs.voxels.classes);
  auto clusters =
      FindClusters({labels, options.min_share, options.tolerance_voxels, options.min_voxels},
                   inputs.voxels,
                   num_threads);
  const ThingMaker maker(options, inputs, labels);
  clusters = JoinTops(inputs.voxels, maker.Space(), options.max_hidden_m, std::move(clusters));
  std::vector<UprightBox> boxes(clusters.size());
  ParallelFor(boxes.size(), num_threads, [&](std::size_t i) {
    boxes[i] = maker.BoxOf(clusters[i], false);
  });
  clusters = SplitAll(inputs.voxels, maker.Space(), JoinParts(inputs.voxels, clusters, boxes));
  std::erase_if(clusters, [&](const Cluster& cluster) { return !maker.IsThing(cluster); });
  std::vector<Thing> things(clusters.size());
  progress.Start(clusters.size());
  ParallelFor(clusters.size(), num_threads, [&](std::size_t i) {
    things[i] = maker.Make(clusters[i]);
    progress.Advance();
  });
  progress.Finish();
  NumberThings(&things);
  return things;
}

std::vector<Keyframe> UniteKeyframes(const std::vector<Tile>& tiles) {
  std::map<int, Keyframe> by_idx;
  for (const Tile& tile : tiles) {
    for (const Keyframe& keyframe : tile.keyframes) {
      by_idx.emplace(keyframe.keyframe_idx, keyframe);
    }
  }
  std::vector<Keyframe> keyframes;
  for (auto& [idx, keyframe] : by_idx) keyframes.push_back(std::move(keyframe));
  return keyframes;
}

nlohmann::json DescribeThings(const std::vector<Thing>& things) {
  nlohmann::json counts = nlohmann::json::object();
  std::size_t num_unseen = 0;
  for (const Thing& thing : things) {
    counts[thing.class_name] = counts.value(thing.class_name, 0) + 1;
    num_unseen += thing.num_views == 0;
  }
  return {{"num_things", things.size()},
          {"num_things_of_class", counts},
          {"num_things_without_view", num_unseen}};
}

}  // namespace nightmap
