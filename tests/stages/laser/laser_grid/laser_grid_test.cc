// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/laser_grid/laser_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/input_error.h"
#include "tests/test_data.h"

namespace nightmap::laser_grid_test {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr double kWall_m = 3.02;  // the wall stands at x = 3.02 in the map

Eigen::Quaterniond Yaw(double yaw_rad) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
}

// A robot that turns in place, 0.1 rad per scan, ten scans per second. Its scanner looks to the
// rear from 0.5 m in front of the robot's centre.
struct Scene {
  LaserGridOptions options;
  LaserGridInput input;

  explicit Scene(int num_scans = 20) {
    Signal laser{SignalKind::kScan, "laser", {Yaw(std::numbers::pi), {0.5, 0, 0.2}}, {}};
    for (int i = 0; i < num_scans; ++i) {
      input.trajectory.push_back({TimeOf_ns(i), {Yaw(0.1 * i), {0, 0, 0}}});
      laser.samples.push_back(ScanAt(i));
    }
    input.scans.push_back(laser);
  }

  static std::int64_t TimeOf_ns(int scan) { return kSecond_ns + scan * kSecond_ns / 10; }

  // A scan of one beam in the map's x, which hits the wall.
  static SignalSample ScanAt(int scan) {
    const double yaw_rad = 0.1 * scan;
    return {TimeOf_ns(scan),
            {-yaw_rad - std::numbers::pi, 0.01, 30},
            {static_cast<float>(kWall_m - 0.5 * std::cos(yaw_rad))}};
  }
};

// Whether all hits lie on the wall.
bool WallIsWhereItStands(const OccupancyGrid& grid) {
  bool some = false;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (grid.At({x, y}) != kOccupiedCell) continue;
      some = true;
      if (std::abs(grid.CenterInMap({x, y}).x() - kWall_m) > grid.resolution_m / 2) return false;
    }
  }
  return some;
}

TEST(LaserGrid, PlacesScansByTheRobotAndTheSensorOnIt) {
  const Scene scene;
  const LaserGridResult result = RunLaserGrid(scene.options, scene.input);
  EXPECT_TRUE(result.skipped.empty());
  EXPECT_TRUE(WallIsWhereItStands(result.map.grid));
  const nlohmann::json report = DescribeLaserGrid(result);
  EXPECT_EQ(report["sensor"], "laser");
  EXPECT_EQ(report["num_scans"], 20);
  EXPECT_EQ(report["num_used_scans"], 20);
  EXPECT_EQ(report["num_beams"], 20);
  EXPECT_EQ(report["num_hits"], 20);
  EXPECT_EQ(report["num_free_cells"].get<std::size_t>() +
                report["num_occupied_cells"].get<std::size_t>() +
                report["num_unknown_cells"].get<std::size_t>(),
            result.map.grid.cells.size());
  EXPECT_EQ(RunLaserGrid(scene.options, scene.input).map.grid.cells, result.map.grid.cells);
}

TEST(LaserGrid, InterpolatesPosesOverGapsThatAreShortEnough) {
  Scene scene;
  std::erase_if(scene.input.trajectory, [](const StampedPose& pose) {
    return pose.time_ns > Scene::TimeOf_ns(5) && pose.time_ns < Scene::TimeOf_ns(10);
  });
  const LaserGridResult result = RunLaserGrid(scene.options, scene.input);
  EXPECT_TRUE(result.skipped.empty());
  EXPECT_TRUE(WallIsWhereItStands(result.map.grid));
  scene.options.max_gap_s = 0.4;
  const LaserGridResult fewer = RunLaserGrid(scene.options, scene.input);
  ASSERT_EQ(fewer.skipped.size(), 4u);
  EXPECT_EQ(fewer.skipped[0],
            "scan at 1.600000: the poses around it are more than max_gap_s apart");
  EXPECT_EQ(DescribeLaserGrid(fewer)["num_used_scans"], 16);
}

TEST(LaserGrid, SkipsScansOutsideTheTrajectory) {
  Scene scene;
  auto& trajectory = scene.input.trajectory;
  trajectory.erase(trajectory.begin());
  trajectory.resize(trajectory.size() - 2);
  const LaserGridResult result = RunLaserGrid(scene.options, scene.input);
  ASSERT_EQ(result.skipped.size(), 3u);
  EXPECT_THAT(result.skipped[0], testing::EndsWith(": is before the trajectory"));
  EXPECT_THAT(result.skipped[2], testing::EndsWith(": is after the trajectory"));
}

// A robot that turns in the middle of a room of 8.1 m, 1 rad/s, 360 beams in 0.075 s. (Walls run
// through the middle of cells.)
LaserGridInput TurningInARoom(double claimed_duration_s) {
  constexpr double kDuration_s = 0.075, kHalf_m = 4.025;
  LaserGridInput input;
  Signal laser{SignalKind::kScan, "laser", {}, {}, claimed_duration_s};
  for (int scan = 0; scan <= 40; ++scan) {
    input.trajectory.push_back({Scene::TimeOf_ns(scan), {Yaw(0.1 * scan), {0, 0, 0}}});
    SignalSample sample{Scene::TimeOf_ns(scan), {0, std::numbers::pi / 180, 30}, {}};
    for (int i = 0; i < 360; ++i) {
      const double angle_rad = 0.1 * scan + kDuration_s * i / 360 + i * std::numbers::pi / 180;
      const double side = std::max(std::abs(std::cos(angle_rad)), std::abs(std::sin(angle_rad)));
      sample.ranges_m.push_back(static_cast<float>(kHalf_m / side));
    }
    if (scan < 40) laser.samples.push_back(sample);
  }
  input.scans.push_back(laser);
  return input;
}

// Occupied cells whose middle is farther than a cell from a wall.
int NumBesideWalls(const OccupancyGrid& grid) {
  int count = 0;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (grid.At({x, y}) != kOccupiedCell) continue;
      const double side_m = grid.CenterInMap({x, y}).cwiseAbs().maxCoeff();
      count += std::abs(side_m - 4.025) > grid.resolution_m ? 1 : 0;
    }
  }
  return count;
}

TEST(LaserGrid, EachBeamIsPlacedAtItsOwnTime) {
  const LaserGridOptions options;
  const ScanGrid moved = RunLaserGrid(options, TurningInARoom(0.075)).map;
  EXPECT_EQ(moved.num_hits, 40U * 360U);
  EXPECT_EQ(NumBesideWalls(moved.grid), 0);
  EXPECT_GT(NumBesideWalls(RunLaserGrid(options, TurningInARoom(0)).map.grid), 20);
}

TEST(LaserGrid, ASensorMustBeChosenAmongSeveral) {
  Scene scene;
  Signal rear = scene.input.scans[0];
  rear.sensor_id = "rear";
  rear.samples.resize(5);
  scene.input.scans.push_back(rear);
  NIGHTMAP_EXPECT_ERROR(
      UsageError,
      RunLaserGrid(scene.options, scene.input),
      "laser_grid.sensor is '': choose one of the sensors that scan: laser, rear");
  scene.options.sensor = "front";
  NIGHTMAP_EXPECT_ERROR(
      UsageError, RunLaserGrid(scene.options, scene.input), "laser_grid.sensor is 'front'");
  scene.options.sensor = "rear";
  EXPECT_EQ(RunLaserGrid(scene.options, scene.input).num_scans, 5u);
}

TEST(LaserGrid, SaysWhatToDoWhenNoScanCanBeUsed) {
  Scene scene;
  for (StampedPose& pose : scene.input.trajectory) pose.time_ns += 100 * kSecond_ns;
  NIGHTMAP_EXPECT_ERROR(
      DataError, RunLaserGrid(scene.options, scene.input), "correct time_offset_s");
  scene.input.trajectory.clear();
  NIGHTMAP_EXPECT_ERROR(
      DataError, RunLaserGrid(scene.options, scene.input), "the trajectory 0 poses");
  scene.input.scans.clear();
  NIGHTMAP_EXPECT_ERROR(
      DataError, RunLaserGrid(scene.options, scene.input), "no sensor of the site scans");
  Scene blind;
  for (SignalSample& scan : blind.input.scans[0].samples) scan.ranges_m = {30};
  NIGHTMAP_EXPECT_ERROR(InputError,
                        RunLaserGrid(blind.options, blind.input),
                        "scans: no beam of 20 scans hit anything");
}

}  // namespace nightmap::laser_grid_test
