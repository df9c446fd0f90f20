// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/scan_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::scan_grid_test {

constexpr int kNumBeams = 720;
constexpr double kStep_rad = 2 * std::numbers::pi / kNumBeams;
constexpr double kLimit_m = 20;
constexpr double kRoom_m = 2.02;  // half the width of the room: its walls are inside of cells
constexpr double kPerson_m = 0.2;

struct Pose2 {
  double x_m, y_m, yaw_rad;
};

Rigid3 ToRigid3(const Pose2& pose) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(pose.yaw_rad, Eigen::Vector3d::UnitZ())),
          {pose.x_m, pose.y_m, 0.3}};
}

double RangeToRoom_m(const Pose2& from, double angle_rad) {
  const double dx = std::cos(angle_rad), dy = std::sin(angle_rad);
  return std::min((std::copysign(kRoom_m, dx) - from.x_m) / dx,
                  (std::copysign(kRoom_m, dy) - from.y_m) / dy);
}

// Range to a round person, or infinity.
double RangeToPerson_m(const Pose2& from, double angle_rad, const Eigen::Vector2d& person) {
  const Eigen::Vector2d way = person - Eigen::Vector2d(from.x_m, from.y_m);
  const Eigen::Vector2d direction(std::cos(angle_rad), std::sin(angle_rad));
  const double along_m = way.dot(direction);
  const double aside2 = way.squaredNorm() - along_m * along_m;
  if (along_m < 0 || aside2 > kPerson_m * kPerson_m) return std::numeric_limits<double>::infinity();
  return along_m - std::sqrt(kPerson_m * kPerson_m - aside2);
}

// Scans of a square room around the origin, and the ranges that they refer to.
struct Recording {
  std::vector<std::vector<float>> ranges_m;
  std::vector<Pose2> poses;

  void Add(Pose2 pose, std::optional<Eigen::Vector2d> person = {}) {
    poses.push_back(pose);
    std::vector<float>& scan_m = ranges_m.emplace_back();
    for (int i = 0; i < kNumBeams; ++i) {
      const double angle_rad = pose.yaw_rad + i * kStep_rad;
      double range_m = RangeToRoom_m(pose, angle_rad);
      if (person) range_m = std::min(range_m, RangeToPerson_m(pose, angle_rad, *person));
      scan_m.push_back(static_cast<float>(range_m));
    }
  }
  void Fill(float range_m) {
    for (auto& scan_m : ranges_m) std::ranges::fill(scan_m, range_m);
  }
  std::vector<PlacedScan> Scans() const {
    std::vector<PlacedScan> scans;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      scans.push_back({ToRigid3(poses[i]), 0, kStep_rad, kLimit_m, ranges_m[i]});
    }
    return scans;
  }
};

Recording Room(int num_scans) {
  Recording recording;
  for (int i = 0; i < num_scans; ++i) {
    recording.Add({0.8 * std::sin(0.7 * i), 0.8 * std::cos(0.3 * i), 0.37 * i});
  }
  return recording;
}

std::uint8_t CellAt(const OccupancyGrid& grid, double x_m, double y_m) {
  return grid.At(grid.CellOf({x_m, y_m}));
}

// Distance of a point to the wall, negative inside the room.
double Outside_m(const Eigen::Vector2d& point) { return point.cwiseAbs().maxCoeff() - kRoom_m; }

TEST(ScanGrid, ARoomHasWallsOfOneCellFreeInsideUnknownOutside) {
  const Recording room = Room(30);
  const ScanGrid result = GridOfScans({}, room.Scans());
  EXPECT_EQ(result.num_beams, 30u * kNumBeams);
  EXPECT_EQ(result.num_hits, 30u * kNumBeams);
  const OccupancyGrid& grid = result.grid;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const Eigen::Vector2d center = grid.CenterInMap({x, y});
      const double outside_m = Outside_m(center);
      const int expected = outside_m > grid.resolution_m / 2    ? kUnknownCell
                           : outside_m < -grid.resolution_m / 2 ? kFreeCell
                                                                : kOccupiedCell;
      EXPECT_EQ(grid.At({x, y}), expected) << center.transpose();
    }
  }
}

TEST(ScanGrid, SomeoneWhoStandsThereInFewScansOfManyIsGone) {
  const Eigen::Vector2d person(1.3, 1.3);
  Recording recording;
  for (int i = 0; i < 60; ++i) {
    const bool is_there = i >= 20 && i < 32;
    recording.Add({0.1 * std::sin(i), 0.1 * std::cos(i), 0.1 * i},
                  is_there ? std::optional(person) : std::nullopt);
  }
  const OccupancyGrid grid = GridOfScans({}, recording.Scans()).grid;
  for (double x_m = 1; x_m < 1.6; x_m += 0.01) {
    for (double y_m = 1; y_m < 1.6; y_m += 0.01) EXPECT_EQ(CellAt(grid, x_m, y_m), kFreeCell);
  }
  // Who stays is an obstacle.
  for (std::size_t i = 0; i < 60; ++i) recording.Add(recording.poses[i], person);
  EXPECT_EQ(CellAt(GridOfScans({}, recording.Scans()).grid, 1.165, 1.165), kOccupiedCell);
}

TEST(ScanGrid, MaximumRangesAndNanAreNoHits) {
  const float kNan = std::numeric_limits<float>::quiet_NaN();
  const float kInfinity = std::numeric_limits<float>::infinity();
  for (const float range_m :
       {kNan, kInfinity, -kInfinity, 0.0f, 0.05f, -1.0f, static_cast<float>(kLimit_m), 81.9f}) {
    Recording recording = Room(1);
    recording.Fill(range_m);
    NIGHTMAP_EXPECT_ERROR(
        DataError, GridOfScans({}, recording.Scans()), "no beam of 1 scans hit anything");
    recording.ranges_m[0][0] = 1;
    const ScanGrid result = GridOfScans({}, recording.Scans());
    EXPECT_EQ(result.num_hits, 1u);
    EXPECT_EQ(std::ranges::count(result.grid.cells, kOccupiedCell), 1);
    EXPECT_LE(std::ranges::count(result.grid.cells, kFreeCell), 21) << "of that beam only";
  }
}

TEST(ScanGrid, ABeamWithoutAHitClearsUpToTheGivenRange) {
  Recording recording;
  recording.Add({0, 0, 0});
  recording.Fill(static_cast<float>(kLimit_m));
  recording.ranges_m[0][0] = 1;
  ScanGridOptions options;
  options.clear_range_m = 3;
  const OccupancyGrid grid = GridOfScans(options, recording.Scans()).grid;
  EXPECT_EQ(CellAt(grid, -2.9, 0), kFreeCell);
  EXPECT_EQ(CellAt(grid, -3.1, 0), kUnknownCell);
  EXPECT_EQ(CellAt(grid, 1, 0.001), kOccupiedCell);
}

TEST(ScanGrid, ABeamThatMeasuredNothingClearsNothing) {
  Recording recording;
  recording.Add({0, 0, 0});
  recording.Fill(-1);
  recording.ranges_m[0][0] = 1;
  ScanGridOptions options;
  options.clear_range_m = 3;
  const ScanGrid result = GridOfScans(options, recording.Scans());
  EXPECT_EQ(result.num_hits, 1u);
  EXPECT_LE(std::ranges::count(result.grid.cells, kFreeCell), 21) << "of the other beam only";
}

TEST(ScanGrid, ALongRangeClearsUpToTheLongestAndHitsNothing) {
  Recording recording;
  recording.Add({0, 0, 0});
  recording.Fill(5);
  recording.ranges_m[0][0] = 1;
  ScanGridOptions options;
  options.max_range_m = 4;
  const ScanGrid result = GridOfScans(options, recording.Scans());
  EXPECT_EQ(result.num_hits, 1u);
  EXPECT_EQ(CellAt(result.grid, -3.9, 0), kFreeCell);
  EXPECT_EQ(CellAt(result.grid, -4.1, 0), kUnknownCell);
}

TEST(ScanGrid, EqualScansGiveEqualBytesAndMoreScansDoNotShiftCells) {
  const Recording room = Room(40);
  const OccupancyGrid grid = GridOfScans({}, room.Scans()).grid;
  EXPECT_EQ(GridToPgm(grid), GridToPgm(GridOfScans({}, room.Scans()).grid));
  Recording longer = room;
  longer.Add({0, 0, 0});
  longer.ranges_m.back()[0] = 7.77f;
  const OccupancyGrid larger = GridOfScans({}, longer.Scans()).grid;
  EXPECT_EQ(larger.origin_in_map, grid.origin_in_map);
  EXPECT_GT(larger.width, grid.width);
}

TEST(ScanGrid, RefusesScansThatAreTooFarApart) {
  Recording room = Room(2);
  for (const double far_m : {1e5, 1e9}) {
    room.poses[1] = {far_m, far_m, 0};
    NIGHTMAP_EXPECT_ERROR(
        DataError, GridOfScans({}, room.Scans()), "check the trajectory, or raise resolution_m");
  }
}

}  // namespace nightmap::scan_grid_test
