// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/object_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "pipeline/laser/match_scan.h"
#include "pipeline/laser/thin_points.h"
#include "stages/laser/scan_localize/object_icp.h"
#include "stages/laser/scan_localize/object_views.h"
#include "stages/laser/scan_localize/scan_candidates.h"

namespace nightmap {
namespace {

using Points = std::vector<Eigen::Vector2d>;

constexpr std::size_t kMaxStartPoints = 40;
constexpr double kStartResolution_m = 0.1;
constexpr double kStartSigma_m = 0.2;
constexpr int kMinShapeWalls = 8;  // fewer have no shape

LikelihoodField FieldOf(const Points& points_in_query) {
  double farthest_m = 1;
  for (const Eigen::Vector2d& point : points_in_query) {
    farthest_m = std::max(farthest_m, point.cwiseAbs().maxCoeff());
  }
  LikelihoodField field({kStartResolution_m, farthest_m + 1, kStartSigma_m});
  field.Add(points_in_query);
  return field;
}

// The poses of a lattice within the rough position at which the cloud comes nearest to the walls.
std::vector<Rigid2> StartsFor(const ObjectFilterOptions& options,
                              const LikelihoodField& cloud_field,
                              const Points& walls_in_map,
                              const RoughPosition& rough) {
  const Points few = SpreadPoints(walls_in_map, kMaxStartPoints);
  const int num_steps = static_cast<int>(rough.radius_m / options.start_step_m);
  std::vector<TemplateMatch> scored;
  for (int y = -num_steps; y <= num_steps; ++y) {
    for (int x = -num_steps; x <= num_steps; ++x) {
      const Eigen::Vector2d offset = options.start_step_m * Eigen::Vector2d(x, y);
      if (offset.norm() > rough.radius_m) continue;
      for (int turn = 0; turn < options.num_headings; ++turn) {
        const Rigid2 pose{WrapAngle_rad(2 * std::numbers::pi * turn / options.num_headings),
                          rough.point_in_map + offset};
        scored.push_back({pose, ScoreOf(cloud_field, few, pose.Inverse())});
      }
    }
  }
  std::ranges::stable_sort(scored, std::greater(), &TemplateMatch::score);
  std::vector<Rigid2> starts;
  for (const TemplateMatch& start : scored) {
    const auto is_same = [&](const Rigid2& other) {
      return IsSamePlace(start.map_from_query, other);
    };
    if (std::ranges::none_of(starts, is_same)) starts.push_back(start.map_from_query);
    if (starts.size() == static_cast<std::size_t>(options.num_starts)) break;
  }
  return starts;
}

ObjectPose PoseWithOverlap(const ObjectScene& scene, const NearObject& object, const Rigid2& pose) {
  const ObjectView view =
      ViewInSight(scene.grid, object.walls_in_map, scene.query, pose, scene.max_range_m);
  const int num_in_sight = view.num_confirmed + view.num_contradicted;
  return {object.object_idx,
          pose,
          num_in_sight,
          static_cast<double>(view.num_confirmed) / std::max(1, num_in_sight)};
}

bool IsInSight(const ObjectScene& scene, const NearObject& object, const Rigid2& pose) {
  return PoseWithOverlap(scene, object, pose).num_in_sight >= kMinShapeWalls;
}

std::vector<Rigid2> PlacesThatSee(const ObjectScene& scene,
                                  const NearObject& object,
                                  const std::vector<TemplateMatch>& matches) {
  std::vector<Rigid2> places;
  for (const TemplateMatch& match : matches) {
    if (IsInSight(scene, object, match.map_from_query)) places.push_back(match.map_from_query);
  }
  return places;
}

}  // namespace

std::vector<NearObject> ObjectsNear(const ObjectFilterOptions& options,
                                    const ObjectScene& scene,
                                    const std::vector<MapObject>& objects) {
  std::vector<NearObject> near;
  if (!scene.query.rough_position) return near;
  const Eigen::Vector2d& rough = scene.query.rough_position->point_in_map;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    MapObject object = objects[i];
    if ((object.map_from_object.translation - rough).norm() >= options.object_distance_m) continue;
    object.size_m.array() += 2 * options.object_margin_m;
    Points walls = WallsOfObjects(scene.grid, {object});
    if (walls.size() >= std::size_t{kMinShapeWalls}) near.push_back({i, std::move(walls)});
  }
  return near;
}

std::vector<ObjectPose> PosesByObjects(const ObjectFilterOptions& options,
                                       const ObjectScene& scene,
                                       const std::vector<NearObject>& objects,
                                       const std::vector<TemplateMatch>& matches) {
  const Points all_points = PointsInQuery(scene.query, scene.max_range_m);
  if (objects.empty() || all_points.empty()) return {};
  const RoughPosition& rough = *scene.query.rough_position;
  const Points points = FilterByVoxels(all_points, options.voxel_m);
  const LikelihoodField field = FieldOf(points);
  std::vector<ObjectPose> poses;
  for (const NearObject& object : objects) {
    const std::vector<Rigid2> places = PlacesThatSee(scene, object, matches);
    auto starts = StartsFor(options, field, object.walls_in_map, rough);
    starts.insert(starts.end(), places.begin(), places.end());
    auto found = MatchToObject(options, object.walls_in_map, points, starts);
    found.insert(found.end(), places.begin(), places.end());
    for (const Rigid2& pose : found) {
      if ((pose.translation - rough.point_in_map).norm() > rough.radius_m) continue;
      poses.push_back(PoseWithOverlap(scene, object, pose));
    }
  }
  std::erase_if(poses, [&](const ObjectPose& pose) {
    return pose.num_in_sight < kMinShapeWalls || pose.overlap < options.min_overlap;
  });
  return poses;
}

std::vector<ObjectPose> PosesApart(std::vector<ObjectPose> poses) {
  std::ranges::stable_sort(poses, [](const ObjectPose& a, const ObjectPose& b) {
    return std::tie(a.object_idx, b.overlap) < std::tie(b.object_idx, a.overlap);
  });
  std::vector<ObjectPose> apart;
  for (const ObjectPose& pose : poses) {
    const auto is_same = [&](const ObjectPose& other) {
      return pose.object_idx == other.object_idx &&
             IsSamePlace(pose.map_from_query, other.map_from_query);
    };
    if (std::ranges::none_of(apart, is_same)) apart.push_back(pose);
  }
  return apart;
}

std::vector<TemplateMatch> FilterByPoses(const ObjectFilterOptions& options,
                                         const ObjectScene& scene,
                                         const std::vector<NearObject>& objects,
                                         const std::vector<ObjectPose>& poses,
                                         std::vector<TemplateMatch> matches) {
  if (poses.empty()) return matches;
  const double max_turn_rad = options.filter_angle_deg * std::numbers::pi / 180;
  std::erase_if(matches, [&](const TemplateMatch& match) {
    const Rigid2& place = match.map_from_query;
    const auto agrees = [&](const ObjectPose& pose) {
      const Rigid2& other = pose.map_from_query;
      return (other.translation - place.translation).norm() <= options.filter_distance_m &&
             std::abs(WrapAngle_rad(other.heading_rad - place.heading_rad)) <= max_turn_rad;
    };
    const auto is_in_sight = [&](const NearObject& object) {
      return IsInSight(scene, object, place);
    };
    return std::ranges::none_of(poses, agrees) && std::ranges::any_of(objects, is_in_sight);
  });
  return matches;
}

}  // namespace nightmap
