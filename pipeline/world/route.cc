// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/route.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/error.h"
#include "pipeline/world/route_keys.h"

namespace nightmap {

namespace {

constexpr double kCornerRadius_m = 0.2;  // smoothing radius of the corners
constexpr double kSpacing_m = 0.02;
constexpr double kNormPower = 4;

// Points every ~2 cm on the closed polyline through the keys. The first key is not repeated.
std::vector<RoutePoint> Resample(const std::vector<RoutePoint>& keys) {
  std::vector<RoutePoint> dense;
  for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
    const RoutePoint& a = keys[i];
    const RoutePoint& b = keys[i + 1];
    const double length_m = (b.position - a.position).norm();
    const int num_steps = static_cast<int>(std::ceil(length_m / kSpacing_m));
    for (int step = 0; step < num_steps; ++step) {
      const double t = static_cast<double>(step) / num_steps;
      dense.push_back({a.position + t * (b.position - a.position),
                       a.heading_rad + t * (b.heading_rad - a.heading_rad),
                       a.floor_m + t * (b.floor_m - a.floor_m)});
    }
  }
  return dense;
}

// Gaussian smoothing on the closed path; `lap_turn_rad` is the increase of the heading over the
// whole path.
std::vector<RoutePoint> Smooth(const std::vector<RoutePoint>& path,
                               double sigma_m,
                               double lap_turn_rad) {
  const int size = static_cast<int>(path.size());
  const int reach = std::min(size / 2, static_cast<int>(std::ceil(3 * sigma_m / kSpacing_m)));
  std::vector<RoutePoint> smooth(path.size());
  for (int i = 0; i < size; ++i) {
    RoutePoint sum;
    double total = 0;
    for (int k = -reach; k <= reach; ++k) {
      const double distance = k * kSpacing_m / sigma_m;
      const double weight = std::exp(-0.5 * distance * distance);
      const int wrapped = ((i + k) % size + size) % size;
      const double turns = i + k < 0 ? -lap_turn_rad : (i + k >= size ? lap_turn_rad : 0);
      const RoutePoint& point = path[static_cast<std::size_t>(wrapped)];
      sum.position += weight * point.position;
      sum.heading_rad += weight * (point.heading_rad + turns);
      sum.floor_m += weight * point.floor_m;
      total += weight;
    }
    smooth[static_cast<std::size_t>(i)] = {
        sum.position / total, sum.heading_rad / total, sum.floor_m / total};
  }
  return smooth;
}

double Cost(const RoutePoint& a, const RoutePoint& b, const RouteOptions& options) {
  const double step = (b.position - a.position).norm() / options.max_step_m;
  const double turn = std::abs(b.heading_rad - a.heading_rad) / options.max_turn_rad;
  return std::pow(std::pow(step, kNormPower) + std::pow(turn, kNormPower), 1 / kNormPower);
}

// The driven part of the path: from its start on, lap after lap, with continuous heading.
std::vector<RoutePoint> Unroll(const std::vector<RoutePoint>& path, const RouteOptions& options) {
  const double raw_gain = path.back().heading_rad - path.front().heading_rad;
  const double gain = std::round(raw_gain / (2 * M_PI)) * 2 * M_PI;
  double lap_m = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    lap_m += (path[(i + 1) % path.size()].position - path[i].position).norm();
  }
  const double length_m = options.length_ratio * lap_m + options.overlap_m;
  const auto start =
      static_cast<std::size_t>(options.start_ratio * static_cast<double>(path.size()));
  std::vector<RoutePoint> unrolled;
  double driven_m = 0;
  for (std::size_t i = start; driven_m < length_m; ++i) {
    const RoutePoint& point = path[i % path.size()];
    const std::size_t lap = i / path.size();
    unrolled.push_back(
        {point.position, point.heading_rad + static_cast<double>(lap) * gain, point.floor_m});
    if (i == start) continue;
    driven_m += (point.position - unrolled[unrolled.size() - 2].position).norm();
  }
  return unrolled;
}

// Turns each point of the closed path to where the path leads.
void HeadAlong(std::vector<RoutePoint>& path) {
  double heading_rad = path.front().heading_rad;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const RoutePoint& before = path[(i + path.size() - 1) % path.size()];
    const RoutePoint& after = path[(i + 1) % path.size()];
    const Eigen::Vector2d way = after.position - before.position;
    heading_rad += std::remainder(std::atan2(way.y(), way.x()) - heading_rad, 2 * std::numbers::pi);
    path[i].heading_rad = heading_rad;
  }
}

}  // namespace

std::vector<RoutePoint> PlanPath(const FloorLayout& layout, const RouteOptions& options) {
  const std::vector<RoutePoint> keys = RouteKeys(layout, options);
  const double lap_turn_rad = keys.back().heading_rad - keys.front().heading_rad;
  std::vector<RoutePoint> path = Smooth(Resample(keys), kCornerRadius_m, lap_turn_rad);
  if (options.differential_drive) HeadAlong(path);
  return path;
}

std::vector<RoutePoint> SampleFrames(const std::vector<RoutePoint>& path,
                                     const RouteOptions& options,
                                     int points_per_frame) {
  const std::vector<RoutePoint> route = Unroll(path, options);
  std::vector<double> cost(route.size(), 0.0);
  for (std::size_t i = 1; i < route.size(); ++i) {
    cost[i] = cost[i - 1] + Cost(route[i - 1], route[i], options);
  }
  const double frame_cost = cost.back() / (options.num_frames - 1);
  if (frame_cost > 1) {
    throw UsageError(
        "num_frames = {} is too few for this route within max_step_m and max_turn_rad: set at "
        "least {}",
        options.num_frames,
        static_cast<int>(std::ceil(cost.back())) + 1);
  }
  const double point_cost = frame_cost / points_per_frame;
  const int num_points = (options.num_frames - 1) * points_per_frame + 1;
  std::vector<RoutePoint> points;
  std::size_t next = 1;
  for (int i = 0; i < num_points; ++i) {
    const double target = std::min(i * point_cost, cost.back());
    while (next + 1 < route.size() && cost[next] < target) ++next;
    const double t = (target - cost[next - 1]) / (cost[next] - cost[next - 1]);
    const RoutePoint& a = route[next - 1];
    const RoutePoint& b = route[next];
    points.push_back({a.position + t * (b.position - a.position),
                      a.heading_rad + t * (b.heading_rad - a.heading_rad),
                      a.floor_m + t * (b.floor_m - a.floor_m)});
  }
  return points;
}

Rigid3 CameraPose(const RoutePoint& point, double height_m, double pitch_rad, double roll_rad) {
  const double c = std::cos(point.heading_rad);
  const double s = std::sin(point.heading_rad);
  const Eigen::Vector3d forward(
      c * std::cos(pitch_rad), s * std::cos(pitch_rad), -std::sin(pitch_rad));
  const Eigen::Vector3d right(s, -c, 0);
  Eigen::Matrix3d rotation;
  rotation << right, forward.cross(right), forward;
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()));
  return {(Eigen::Quaterniond(rotation) * roll).normalized(),
          {point.position.x(), point.position.y(), height_m}};
}

std::vector<Rigid3> PlanRoute(const FloorLayout& layout,
                              const RouteOptions& options,
                              const SyntheticCameraOptions& camera) {
  std::vector<Rigid3> poses;
  const double sway = options.differential_drive ? 0 : 1;
  double driven_m = 0;
  Eigen::Vector2d previous = Eigen::Vector2d::Zero();
  for (const RoutePoint& point : SampleFrames(PlanPath(layout, options), options)) {
    if (!poses.empty()) driven_m += (point.position - previous).norm();
    previous = point.position;
    const double sway_m = sway * 0.006 * std::sin(2.1 * driven_m);
    const double height_m = point.floor_m + camera.camera_height_m + sway_m;
    const double pitch_rad = camera.pitch_rad + sway * 0.02 * std::sin(1.3 * driven_m);
    const double roll_rad = sway * 0.006 * std::sin(1.7 * driven_m);
    poses.push_back(CameraPose(point, height_m, pitch_rad, roll_rad));
  }
  return poses;
}

}  // namespace nightmap
