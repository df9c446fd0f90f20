// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/plan_queries.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/world/route.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kQueryStream = 501;
constexpr int kNumAttempts = 600;
constexpr int kNumColumns = 16;
constexpr int kNumRows = 12;
constexpr double kMinMedianDepth_m = 0.7;
constexpr double kNearby_m = 1.2;  // frames of the route within this count as neighbours

class QueryPlanner {
 public:
  QueryPlanner(const SyntheticWorld& world,
               const std::vector<Rigid3>& route,
               const SyntheticCameraOptions& camera,
               const DepthSensorOptions& sensor,
               const QueryOptions& options)
      : world_(world),
        route_(route),
        camera_(camera),
        pinhole_(camera.Pinhole()),
        sensor_(sensor),
        options_(options) {}

  std::optional<SyntheticQuery> TryFrame(int frame_idx, Random& random) const {
    const Rigid3& frame = route_[static_cast<std::size_t>(frame_idx)];
    const double angle_rad = random.Uniform(0, 2 * std::numbers::pi);
    const double offset_m = random.Uniform(options_.min_offset_m, options_.max_offset_m);
    const Eigen::Vector3d forward = frame.rotation * Eigen::Vector3d::UnitZ();
    RoutePoint point;
    point.position = frame.translation.head<2>() +
                     offset_m * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    point.heading_rad = std::atan2(forward.y(), forward.x()) +
                        options_.max_heading_change_rad * random.Uniform(-1, 1);
    const double height_m =
        frame.translation.z() + options_.max_height_change_m * random.Uniform(-1, 1);
    const double pitch_rad = camera_.pitch_rad + 0.05 * random.Uniform(-1, 1);
    SyntheticQuery query;
    query.building_from_camera =
        CameraPose(point, height_m, pitch_rad, 0.03 * random.Uniform(-1, 1));
    query.frame_idx = frame_idx;
    query.offset_m = DistanceToRoute(point.position);
    if (!IsFree(point.position, frame.translation) || query.offset_m < options_.min_offset_m)
      return {};
    query.covisible_ratio = CovisibleRatio(query.building_from_camera);
    if (query.covisible_ratio < options_.min_covisible_ratio) return {};
    return query;
  }

 private:
  double DistanceToRoute(const Eigen::Vector2d& position) const {
    double smallest = std::numeric_limits<double>::infinity();
    for (const Rigid3& pose : route_) {
      smallest = std::min(smallest, (pose.translation.head<2>() - position).norm());
    }
    return smallest;
  }

  // Whether a position is far from obstacles, indoors, and not behind a wall from its frame.
  bool IsFree(const Eigen::Vector2d& position, const Eigen::Vector3d& frame_position) const {
    if (!world_.layout.IsIndoors(position.x(), position.y())) return false;
    if (Clearance(world_.scene.boxes, position, 0.05, 1.5) < options_.clearance_m) return false;
    const Eigen::Vector3d target(position.x(), position.y(), frame_position.z());
    return !world_.rays->IsBlocked(frame_position, target - frame_position, 1.0);
  }

  std::vector<Eigen::Vector3d> SeenPoints(const Rigid3& building_from_camera) const {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < kNumColumns * kNumRows; ++i) {
      const int row = i / kNumColumns;
      const Eigen::Vector2d pixel((i % kNumColumns + 0.5) * pinhole_.width / kNumColumns,
                                  (row + 0.5) * pinhole_.height / kNumRows);
      const Eigen::Vector3d direction =
          building_from_camera.rotation * pinhole_.BackProject(pixel, 1.0);
      const RayHit hit = world_.rays->Cast(building_from_camera.translation, direction);
      if (hit.surface_idx < 0) continue;
      points.push_back(building_from_camera.translation + hit.distance * direction);
    }
    return points;
  }

  bool IsSeen(const Eigen::Vector3d& point, const Rigid3& building_from_camera) const {
    const Eigen::Vector3d in_camera = building_from_camera.Inverse() * point;
    if (in_camera.z() < sensor_.min_depth_m || in_camera.z() > sensor_.max_depth_m) return false;
    const auto pixel = pinhole_.Project(in_camera);
    if (!pixel || !pinhole_.Contains(*pixel)) return false;
    const Eigen::Vector3d to_point = point - building_from_camera.translation;
    return !world_.rays->IsBlocked(building_from_camera.translation, to_point, 0.995);
  }

  // 0 for a query that looks at a wall directly in front of it.
  double CovisibleRatio(const Rigid3& building_from_camera) const {
    const std::vector<Eigen::Vector3d> points = SeenPoints(building_from_camera);
    std::vector<double> depths;
    int num_seen = 0;
    for (const Eigen::Vector3d& point : points) {
      depths.push_back((building_from_camera.Inverse() * point).z());
      const bool is_seen = std::any_of(route_.begin(), route_.end(), [&](const Rigid3& pose) {
        const double distance_m = (pose.translation - building_from_camera.translation).norm();
        return distance_m < kNearby_m && IsSeen(point, pose);
      });
      if (is_seen) ++num_seen;
    }
    if (depths.empty()) return 0;
    const double median_m = Median(std::move(depths));
    if (median_m < kMinMedianDepth_m || median_m > sensor_.max_depth_m) return 0;
    return static_cast<double>(num_seen) / (kNumColumns * kNumRows);
  }

  const SyntheticWorld& world_;
  const std::vector<Rigid3>& route_;
  const SyntheticCameraOptions& camera_;
  Camera pinhole_;
  const DepthSensorOptions& sensor_;
  const QueryOptions& options_;
};

}  // namespace

std::vector<SyntheticQuery> PlanQueries(const SyntheticWorld& world,
                                        const std::vector<Rigid3>& route,
                                        const SyntheticCameraOptions& camera,
                                        const DepthSensorOptions& sensor,
                                        const QueryOptions& options,
                                        int seed,
                                        int num_threads) {
  const QueryPlanner planner(world, route, camera, sensor, options);
  const auto num_queries = static_cast<std::size_t>(options.num_queries);
  std::vector<SyntheticQuery> queries(num_queries);
  ParallelFor(num_queries, num_threads, [&](std::size_t i) {
    Random random(static_cast<std::uint64_t>(seed), kQueryStream, i);
    const std::size_t first = i * route.size() / num_queries;
    const std::size_t last = std::max(first + 1, (i + 1) * route.size() / num_queries);
    for (int attempt = 0; attempt < kNumAttempts; ++attempt) {
      const bool is_nearby = attempt < kNumAttempts / 2;
      const std::size_t frame_idx =
          is_nearby ? first + random.Index(last - first) : random.Index(route.size());
      const auto query = planner.TryFrame(static_cast<int>(frame_idx), random);
      if (!query) continue;
      queries[i] = *query;
      return;
    }
    throw UsageError(
        "no pose for query {} after {} attempts: lower min_offset_m, query_clearance_m or "
        "min_covisible_ratio",
        i,
        kNumAttempts);
  });
  return queries;
}

}  // namespace nightmap
