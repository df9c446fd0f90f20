// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/walkers.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kWalkerStream = 421;
constexpr int kNumWalkerAttempts = 4000;

constexpr double kHalfStance_m = 0.07;  // from the track to the axis of a leg
constexpr double kSwing_m = 0.2;
constexpr double kStride_m = 1.4;  // distance until the same leg is in front again
constexpr double kLegClearance_m = kHalfStance_m + kLegRadius_m + 0.01;  // of the track

constexpr double kTrackStep_m = 0.05;
constexpr double kMaxHalfTrack_m = 3;
constexpr double kMinTrack_m = 1.5;
constexpr double kMinReach_m = 0.4;  // from the robot to the place that is tried
constexpr double kMaxReach_m = 3;

// Legs and robot approach each other by less than kApproach_m in half a time step.
constexpr double kTimeStep_s = 0.01;
constexpr double kApproach_m = 0.02;

class WalkerPlanner {
 public:
  WalkerPlanner(const SyntheticWorld& world, const RobotDrive& drive)
      : world_(world), drive_(drive) {}

  // One attempt, with a track through a place that the robot sees at `time_s`.
  std::optional<Walker> Try(double time_s, Random& random) const {
    const RoutePoint robot = drive_.At(time_s);
    const double bearing_rad = random.Uniform(0, 2 * std::numbers::pi);
    const double reach_m = random.Uniform(kMinReach_m, kMaxReach_m);
    // Three of four people walk along the walls, which have the directions of the axes.
    const std::size_t side = random.Index(4);
    const double free_rad = random.Uniform(0, 2 * std::numbers::pi);
    const double track_rad =
        random.Uniform() < 0.25 ? free_rad : static_cast<double>(side) * std::numbers::pi / 2;
    Walker walker;
    walker.floor_m = robot.floor_m;
    walker.speed_m_per_s = random.Uniform(0.6, 1.3);
    walker.start_m = random.Uniform(0, 4 * kMaxHalfTrack_m);
    if (!IsOnAFloor(robot.floor_m)) return {};
    const Eigen::Vector2d place =
        robot.position + reach_m * Eigen::Vector2d(std::cos(bearing_rad), std::sin(bearing_rad));
    if (!IsFree(place, walker.floor_m) || !IsInSight(robot, place)) return {};
    const Eigen::Vector2d along(std::cos(track_rad), std::sin(track_rad));
    walker.from = EndOfTrack(place, -along, walker.floor_m);
    walker.to = EndOfTrack(place, along, walker.floor_m);
    if ((walker.to - walker.from).norm() < kMinTrack_m || !KeepsAway(walker)) return {};
    return walker;
  }

 private:
  // The ramp between two floors is no place to walk.
  bool IsOnAFloor(double floor_m) const {
    const double storey_m = world_.layout.storey_m;
    return world_.layout.num_floors == 1 ||
           std::abs(floor_m - std::round(floor_m / storey_m) * storey_m) < 1e-6;
  }

  bool IsFree(const Eigen::Vector2d& place, double floor_m) const {
    return world_.layout.IsIndoors(place.x(), place.y()) &&
           Clearance(world_.scene.boxes, place, floor_m + 0.02, floor_m + kLegHeight_m) >=
               kLegClearance_m;
  }

  bool IsInSight(const RoutePoint& robot, const Eigen::Vector2d& place) const {
    const Eigen::Vector2d way = place - robot.position;
    const Eigen::Vector3d eye(robot.position.x(), robot.position.y(), robot.floor_m + 0.3);
    return !world_.rays->IsBlocked(eye, {way.x(), way.y(), 0}, 1.0);
  }

  // The legs swing beyond the ends of the track.
  Eigen::Vector2d EndOfTrack(const Eigen::Vector2d& place,
                             const Eigen::Vector2d& direction,
                             double floor_m) const {
    double free_m = 0;
    while (free_m < kMaxHalfTrack_m + kSwing_m &&
           IsFree(place + (free_m + kTrackStep_m) * direction, floor_m)) {
      free_m += kTrackStep_m;
    }
    return place + std::max(0.0, free_m - kSwing_m) * direction;
  }

  bool KeepsAway(const Walker& walker) const {
    const auto num_steps = static_cast<int>(std::ceil(drive_.Duration_s() / kTimeStep_s));
    for (int i = 0; i <= num_steps; ++i) {
      const double time_s = i * kTimeStep_s;
      const RoutePoint robot = drive_.At(time_s);
      if (std::abs(robot.floor_m - walker.floor_m) > 1) continue;
      for (const Eigen::Vector2d& leg : LegsAt(walker, time_s)) {
        if ((leg - robot.position).norm() < kWalkerDistance_m + kApproach_m) return false;
      }
    }
    return true;
  }

  const SyntheticWorld& world_;
  const RobotDrive& drive_;
};

}  // namespace

std::array<Eigen::Vector2d, 2> LegsAt(const Walker& walker, double time_s) {
  const double length_m = (walker.to - walker.from).norm();
  const Eigen::Vector2d along = (walker.to - walker.from) / length_m;
  const Eigen::Vector2d aside(-along.y(), along.x());
  const double walked_m = walker.start_m + walker.speed_m_per_s * time_s;
  const double in_lap_m = std::fmod(walked_m, 2 * length_m);
  const double at_m = in_lap_m < length_m ? in_lap_m : 2 * length_m - in_lap_m;
  // A function of the place, so that the legs do not jump where the walker turns.
  const double swing_m = kSwing_m * std::sin(2 * std::numbers::pi * at_m / kStride_m);
  const Eigen::Vector2d middle = walker.from + at_m * along;
  const Eigen::Vector2d step = swing_m * along + kHalfStance_m * aside;
  return {middle + step, middle - step};
}

std::vector<Walker> PlanWalkers(const SyntheticWorld& world,
                                const RobotDrive& drive,
                                int num_walkers,
                                std::uint64_t seed) {
  const WalkerPlanner planner(world, drive);
  std::vector<Walker> walkers;
  for (int i = 0; i < num_walkers; ++i) {
    Random random(seed, kWalkerStream, static_cast<std::uint64_t>(i));
    std::optional<Walker> walker;
    for (int attempt = 0; attempt < kNumWalkerAttempts && !walker; ++attempt) {
      // First in this walker's share of the drive, then anywhere.
      const double share = (i + random.Uniform()) / num_walkers;
      const double anywhere = random.Uniform();
      const double ratio = attempt < kNumWalkerAttempts / 2 ? share : anywhere;
      walker = planner.Try(ratio * drive.Duration_s(), random);
    }
    if (!walker) {
      throw UsageError("no place for walker {} of num_walkers = {} after {} attempts: lower it",
                       i + 1,
                       num_walkers,
                       kNumWalkerAttempts);
    }
    walkers.push_back(*walker);
  }
  return walkers;
}

}  // namespace nightmap
