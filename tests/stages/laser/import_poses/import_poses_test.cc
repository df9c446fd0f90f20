// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/import_poses/import_poses.h"

#include "pipeline/base/files.h"
#include "pipeline/base/input_error.h"
#include "pipeline/io/trajectory_io.h"
#include "tests/test_data.h"

namespace nightmap::import_poses_test {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

Rigid3 PoseOf(double x_m) { return {Eigen::Quaterniond::Identity(), {x_m, 0, 0}}; }

// Scans at 1, 2, ... 5 s.
Signal Scans() {
  Signal scans{SignalKind::kScan, "laser", {}, {}};
  for (int i = 1; i <= 5; ++i) scans.samples.push_back({i * kSecond_ns, {0, 0.1, 30}, {1, 2}});
  return scans;
}

TEST(ImportPoses, ScansGetThePoseAtTheirTime) {
  ImportPosesOptions options;
  options.max_gap_s = 1;
  const ImportPosesInput input{{Scans()},
                               {{kSecond_ns, PoseOf(1)},
                                {2 * kSecond_ns - kSecond_ns / 2, PoseOf(2)},
                                {2 * kSecond_ns + kSecond_ns / 2, PoseOf(4)},
                                {5 * kSecond_ns, PoseOf(9)}}};
  const ImportPosesResult result = RunImportPoses(options, input);
  EXPECT_EQ(result.num_scans, 5U);
  ASSERT_EQ(result.poses.size(), 3U);  // those at 3 and 4 s are in a gap of 2.5 s
  EXPECT_EQ(result.poses[0].pose.translation.x(), 1);
  EXPECT_NEAR(result.poses[1].pose.translation.x(), 3, 1e-12);
  EXPECT_EQ(result.poses[2].time_ns, 5 * kSecond_ns);
  ASSERT_EQ(result.skipped.size(), 2U);
  EXPECT_EQ(result.skipped[0], "scan at 3.000000: no given pose is near in time");
}

TEST(ImportPoses, PosesOfAnotherClockAreRefused) {
  const ImportPosesInput input{{Scans()}, {{900 * kSecond_ns, PoseOf(0)}}};
  NIGHTMAP_EXPECT_ERROR(InputError, RunImportPoses({}, input), "the times of both");
  NIGHTMAP_EXPECT_ERROR(InputError, RunImportPoses({}, {{}, {}}), "no sensor of the site scans");
}

TEST(ImportPoses, ReadsTrajectoriesAndCorrectedLogs) {
  const TemporaryFolder folder;
  WriteFile(folder.Path() / "a.tum", "# time x y\n1.5 2 3 0 0 0 0 1\n");
  WriteFile(folder.Path() / "a.log",
            "# a log\nODOM 9 9 9 0 0 0 1.0 host 1.0\n"
            "FLASER 3 1.0 2.0 3.0 2.5 -1.5 0.5 2.5 -1.5 0.5 1.5 host 1.5\n");
  const auto tum = ReadGivenPoses({}, folder.Path() / "a.tum");
  ASSERT_EQ(tum.size(), 1U);
  EXPECT_EQ(tum[0].pose.translation, Eigen::Vector3d(2, 3, 0));
  const auto log = ReadGivenPoses({}, folder.Path() / "a.log");
  ASSERT_EQ(log.size(), 1U);
  EXPECT_EQ(log[0].time_ns, 3 * kSecond_ns / 2);
  EXPECT_EQ(log[0].pose.translation, Eigen::Vector3d(2.5, -1.5, 0));
  EXPECT_NEAR(2 * std::atan2(log[0].pose.rotation.z(), log[0].pose.rotation.w()), 0.5, 1e-12);
  NIGHTMAP_EXPECT_ERROR(DataError, ReadGivenPoses({}, folder.Path() / "none.log"), "none.log");
  WriteFile(folder.Path() / "b.log", "FLASER 3 1.0 2.0\n");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadGivenPoses({}, folder.Path() / "b.log"), "b.log");
}

}  // namespace nightmap::import_poses_test
