// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/carry_scans/carry_scans.h"

#include <cmath>

#include "pipeline/base/input_error.h"
#include "tests/test_data.h"

namespace nightmap::carry_scans_test {

constexpr int kNumScans = 21;
constexpr int kScansPerKeyscan = 5;

std::int64_t TimeAt(int scan) { return 100'000'000LL * (scan + 1); }

Rigid3 Planar(double x, double y, double heading_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ())), {x, y, 0}};
}

// Along a curve.
std::vector<StampedPose> Scans() {
  std::vector<StampedPose> scans;
  for (int i = 0; i < kNumScans; ++i) {
    scans.push_back({TimeAt(i), Planar(0.1 * i, std::sin(0.2 * i), 0.07 * i)});
  }
  return scans;
}

// Every fifth scan, moved by map_from_start.
std::vector<StampedPose> Keyscans(const Rigid3& map_from_start) {
  std::vector<StampedPose> keyscans;
  const std::vector<StampedPose> scans = Scans();
  for (std::size_t i = 0; i < scans.size(); i += kScansPerKeyscan) {
    keyscans.push_back({scans[i].time_ns, map_from_start * scans[i].pose});
  }
  return keyscans;
}

void ExpectNear(const Rigid3& a, const Rigid3& b, double tolerance = 1e-9) {
  EXPECT_LT((a.translation - b.translation).norm(), tolerance);
  EXPECT_LT(AngleBetween_rad(a, b), std::max(tolerance, 1e-7));
}

TEST(CarryScans, WhereTheGraphMovedNothingScansStay) {
  const std::vector<StampedPose> scans = Scans();
  const std::vector<StampedPose> poses = RunCarryScans({scans, Keyscans({})});
  ASSERT_EQ(poses.size(), scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_EQ(poses[i].time_ns, scans[i].time_ns);
    ExpectNear(poses[i].pose, scans[i].pose);
  }
}

TEST(CarryScans, ScansMoveAsOneWithTheGraph) {
  const Rigid3 map_from_start = Planar(7, -3, 2.5);
  const std::vector<StampedPose> scans = Scans();
  const std::vector<StampedPose> poses = RunCarryScans({scans, Keyscans(map_from_start)});
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ExpectNear(poses[i].pose, map_from_start * scans[i].pose);
  }
}

// A loop moved the third keyscan: it is where the graph has it, scans by its side go along in
// proportion, and what lies between other keyscans stays.
TEST(CarryScans, ScansBetweenKeyscansFollowBoth) {
  const std::vector<StampedPose> scans = Scans();
  std::vector<StampedPose> keyscans = Keyscans({});
  const Eigen::Vector3d moved_m(0.3, -0.2, 0);
  keyscans[2].pose.translation += moved_m;
  const std::vector<StampedPose> poses = RunCarryScans({scans, keyscans});
  ExpectNear(poses[10].pose, keyscans[2].pose);
  double before_m = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const double shift_m = (poses[i].pose.translation - scans[i].pose.translation).norm();
    if (i <= 5 || i >= 15) {
      EXPECT_LT(shift_m, 1e-9) << i;
    } else if (i <= 10) {
      EXPECT_GT(shift_m, before_m) << i;
    } else {
      EXPECT_LT(shift_m, before_m) << i;
    }
    EXPECT_LE(shift_m, moved_m.norm() + 1e-9);
    EXPECT_NEAR(poses[i].pose.translation.z(), 0, 1e-9);
    before_m = shift_m;
  }
}

// The scans after the last keyscan, and those before the first: a scanner that sees nothing at the
// start has no keyscan there.
TEST(CarryScans, ScansBeyondTheKeyscansMoveWithTheNearest) {
  const Rigid3 map_from_start = Planar(1, 2, -0.5);
  const std::vector<StampedPose> scans = Scans();
  std::vector<StampedPose> keyscans = Keyscans(map_from_start);
  keyscans.pop_back();
  keyscans.erase(keyscans.begin());
  const std::vector<StampedPose> poses = RunCarryScans({scans, keyscans});
  ASSERT_EQ(poses.size(), scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ExpectNear(poses[i].pose, map_from_start * scans[i].pose);
  }
}

TEST(CarryScans, KeyscansThatAreNoScansAreRefused) {
  std::vector<StampedPose> keyscans = Keyscans({});
  keyscans[1].time_ns += 1;
  NIGHTMAP_EXPECT_ERROR(InputError,
                        RunCarryScans({Scans(), keyscans}),
                        "there is a keyscan and no scan at 0.600000001 s");
  NIGHTMAP_EXPECT_ERROR(InputError, RunCarryScans({Scans(), {}}), "holds no keyscan");
}

}  // namespace nightmap::carry_scans_test
