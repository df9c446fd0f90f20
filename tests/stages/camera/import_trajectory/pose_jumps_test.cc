// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/import_trajectory/pose_jumps.h"

#include <cmath>

#include "stages/camera/import_trajectory/import_trajectory.h"
#include "tests/test_data.h"

namespace nightmap::pose_jumps_test {

constexpr std::int64_t kStep_ns = 33'000'000;

// A person who runs to and fro at up to 5 m/s.
std::vector<StampedPose> Runner() {
  std::vector<StampedPose> poses;
  for (int i = 0; i < 200; ++i) {
    const double time_s = 1e-9 * static_cast<double>(i * kStep_ns);
    poses.push_back(
        {i * kStep_ns, {Eigen::Quaterniond::Identity(), {2 * std::sin(2.5 * time_s), 0, 0}}});
  }
  return poses;
}

TEST(PoseJumps, ARunnerDoesNotJump) {
  const PoseJumps jumps = FindPoseJumps(Runner());
  EXPECT_TRUE(jumps.away_ns.empty());
  EXPECT_TRUE(jumps.lasting_ns.empty());
  EXPECT_NO_THROW(JudgeJumps(jumps, "x.tum"));
}

TEST(PoseJumps, LonePosesAreFoundAnywhere) {
  for (const std::size_t lone : {0U, 1U, 77U, 198U, 199U}) {
    for (const double away_m : {1.0, 1000.0}) {
      auto poses = Runner();
      poses[lone].pose.translation.y() += away_m;
      const PoseJumps jumps = FindPoseJumps(poses);
      EXPECT_EQ(jumps.away_ns, std::vector{poses[lone].time_ns});
      EXPECT_TRUE(jumps.lasting_ns.empty());
    }
  }
}

TEST(PoseJumps, AFewAwayAreRefusedByTime) {
  auto poses = Runner();
  for (const std::size_t i : {50U, 51U, 52U, 53U, 120U}) poses[i].pose.translation.z() -= 3;
  const PoseJumps jumps = FindPoseJumps(poses);
  EXPECT_EQ(jumps.away_ns.size(), 5U);
  NIGHTMAP_EXPECT_ERROR(DataError,
                        JudgeJumps(jumps, "x.tum"),
                        "at time_s 1.650000, 1.683000, 1.716000, ...: remove these lines");
}

// A loop that another system closed while it ran: the map is torn, and yet of use.
TEST(PoseJumps, AJumpThatStaysIsOnlyWarnedOf) {
  auto poses = Runner();
  for (std::size_t i = 100; i < poses.size(); ++i) poses[i].pose.translation.y() += 2;
  const PoseJumps jumps = FindPoseJumps(poses);
  EXPECT_TRUE(jumps.away_ns.empty());
  EXPECT_EQ(jumps.lasting_ns, std::vector{poses[100].time_ns});
  EXPECT_NO_THROW(JudgeJumps(jumps, "x.tum"));
}

TEST(PoseJumps, TooFewPosesAreNoJumps) {
  for (const std::size_t count : {0U, 1U, 2U}) {
    auto poses = Runner();
    poses.resize(count);
    EXPECT_TRUE(FindPoseJumps(poses).away_ns.empty());
  }
}

}  // namespace nightmap::pose_jumps_test
