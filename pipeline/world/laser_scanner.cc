// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/laser_scanner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "pipeline/base/random.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kScanNoiseStream = 431;
constexpr std::uint64_t kGlassStream = 432;
constexpr std::uint64_t kBlackStream = 433;
constexpr double kGlassStretch_m = 1;
constexpr float kDarkTint = 0.38F;
constexpr double kMinRange_m = 0.02;
constexpr double kNothing_m = std::numeric_limits<double>::infinity();

// Distance along a ray of unit direction to a circle that does not contain its origin; infinity
// when the ray misses it.
double DistanceToCircle(const Eigen::Vector2d& origin,
                        const Eigen::Vector2d& direction,
                        const Eigen::Vector2d& center,
                        double radius) {
  const Eigen::Vector2d offset = center - origin;
  const double along = offset.dot(direction);
  const double half_chord_squared = radius * radius - (offset.squaredNorm() - along * along);
  if (along <= 0 || half_chord_squared < 0) return kNothing_m;
  return along - std::sqrt(half_chord_squared);
}

}  // namespace

LaserScanner::LaserScanner(const SyntheticWorld& world,
                           std::vector<Walker> walkers,
                           const ScannerOptions& options,
                           std::uint64_t building_seed)
    : world_(world),
      walkers_(std::move(walkers)),
      options_(options),
      building_seed_(building_seed) {}

bool LaserScanner::IsGlass(const RayHit& hit) const {
  const Surface& surface = world_.scene.surfaces[static_cast<std::size_t>(hit.surface_idx)];
  if (surface.label != SurfaceLabel::kWall && surface.label != SurfaceLabel::kDoor) return false;
  const auto stretch = static_cast<std::uint64_t>(hit.a * surface.edge_u.norm() / kGlassStretch_m);
  const auto surface_idx = static_cast<std::uint64_t>(hit.surface_idx);
  return Random(building_seed_, kGlassStream, (surface_idx << 20) + stretch).Uniform() <
         options_.glass_ratio;
}

bool LaserScanner::IsBlack(const RayHit& hit) const {
  const auto surface_idx = static_cast<std::size_t>(hit.surface_idx);
  return world_.scene.surfaces[surface_idx].material.tint.mean() < kDarkTint ||
         Random(building_seed_, kBlackStream, surface_idx).Uniform() < options_.black_ratio;
}

double LaserScanner::ExactRange_m(const RoutePoint& robot,
                                  double bearing_rad,
                                  double time_s) const {
  const Eigen::Vector2d direction(std::cos(bearing_rad), std::sin(bearing_rad));
  double leg_m = kNothing_m;
  for (const Walker& walker : walkers_) {
    const double above_floor_m = robot.floor_m + options_.height_m - walker.floor_m;
    if (above_floor_m < 0 || above_floor_m > kLegHeight_m) continue;
    for (const Eigen::Vector2d& leg : LegsAt(walker, time_s)) {
      leg_m = std::min(leg_m, DistanceToCircle(robot.position, direction, leg, kLegRadius_m));
    }
  }
  const Eigen::Vector3d origin(
      robot.position.x(), robot.position.y(), robot.floor_m + options_.height_m);
  const RayHit hit = world_.rays->Cast(origin, {direction.x(), direction.y(), 0});
  if (hit.surface_idx < 0 || leg_m < hit.distance) return leg_m;
  if (IsGlass(hit)) return kNothing_m;
  if (hit.distance > options_.black_range_m && IsBlack(hit)) return kNothing_m;
  return hit.distance;
}

std::vector<float> LaserScanner::Scan(const RobotDrive& drive,
                                      double time_s,
                                      std::uint64_t noise_seed) const {
  Random random(noise_seed, kScanNoiseStream);
  const double field_of_view_rad = options_.field_of_view_deg * std::numbers::pi / 180;
  std::vector<float> ranges_m;
  for (int i = 0; i < options_.num_beams; ++i) {
    // Drawn for every beam, so that one that is missed does not shift the noise of those after it.
    const double gaussian = random.Gaussian();
    const bool is_missed = random.Uniform() < options_.miss_ratio;
    const double turn = static_cast<double>(i) / options_.num_beams;
    const double beam_time_s = time_s + turn * options_.duration_s;
    const RoutePoint robot = drive.At(beam_time_s);
    const double bearing_rad = robot.heading_rad + field_of_view_rad * (turn - 0.5);
    const double exact_m = ExactRange_m(robot, bearing_rad, beam_time_s);
    double range_m = options_.max_range_m;
    if (!is_missed && exact_m < options_.max_range_m) {
      const double sigma_m = options_.noise_constant_m + options_.noise_per_m * exact_m;
      range_m = std::clamp(exact_m + sigma_m * gaussian, kMinRange_m, options_.max_range_m);
    }
    ranges_m.push_back(static_cast<float>(range_m));
  }
  return ranges_m;
}

}  // namespace nightmap
