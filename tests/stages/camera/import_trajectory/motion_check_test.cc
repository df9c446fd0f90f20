// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/import_trajectory/motion_check.h"

#include <cmath>
#include <numbers>

#include "pipeline/base/random.h"
#include "pipeline/recording/frame_lists.h"
#include "stages/camera/import_trajectory/import_trajectory.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::motion_check_test {

using testing::ContainsRegex;
using testing::HasSubstr;

const std::string kThousand = "(99[0-9]|10[0-9][0-9])[.0-9]* times";

constexpr std::int64_t kStep_ns = 20'000'000;

Eigen::Vector3d NoiseOf(Random& random, double sigma) {
  return sigma * Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian());
}

Rigid3 Perturbed(Random& random, const Rigid3& pose, double sigma) {
  Vector6d step;
  step << NoiseOf(random, sigma), NoiseOf(random, sigma);
  return PerturbLeft(step, pose);
}

// A hand-held camera that walks in curves of several metres, at 50 Hz.
std::vector<StampedPose> Walk() {
  std::vector<StampedPose> poses;
  for (int i = 0; i < 1500; ++i) {
    const double time_s = 1e-9 * static_cast<double>(i * kStep_ns);
    const Eigen::Vector3d position(5 + 3 * std::sin(0.3 * time_s) + 0.2 * std::sin(2 * time_s),
                                   2 * std::cos(0.4 * time_s),
                                   1.5 + 0.1 * std::sin(3 * time_s));
    const Eigen::Quaterniond rotation =
        Eigen::AngleAxisd(0.6 * time_s + 0.5 * std::sin(1.5 * time_s), Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(-std::numbers::pi / 2 + 0.2 * std::sin(1.7 * time_s),
                          Eigen::Vector3d::UnitX());
    poses.push_back({i * kStep_ns, {rotation, position}});
  }
  return poses;
}

// Motions that features measure, 3 mm and 3 mrad noisy; one in ten is of a moving thing.
std::vector<MeasuredMotion> Measured() {
  Random random(3);
  const auto poses = Walk();
  std::vector<MeasuredMotion> motions;
  for (std::size_t a = 60; a + 75 < poses.size(); a += 15) {
    const std::size_t b = a + 15;
    const Rigid3 b_from_a = poses[b].pose.Inverse() * poses[a].pose;
    motions.push_back({poses[a].time_ns,
                       poses[b].time_ns,
                       Perturbed(random, b_from_a, motions.size() % 10 == 5 ? 0.5 : 0.003)});
  }
  return motions;
}

std::string Contradiction(const std::vector<StampedPose>& given) {
  return CompareMotions(given, Measured()).contradiction;
}

std::vector<StampedPose> Scaled(double factor) {
  auto poses = Walk();
  for (StampedPose& stamped : poses) stamped.pose.translation *= factor;
  return poses;
}

std::vector<StampedPose> Later(std::int64_t shift_ns) {
  auto poses = Walk();
  for (StampedPose& stamped : poses) stamped.time_ns += shift_ns;
  return poses;
}

// As a file with columns qw qx qy qz is read.
std::vector<StampedPose> Wxyz(std::vector<StampedPose> poses) {
  for (StampedPose& stamped : poses) {
    const Eigen::Quaterniond q = stamped.pose.rotation;
    stamped.pose.rotation = Eigen::Quaterniond(q.z(), q.w(), q.x(), q.y());
  }
  return poses;
}

TEST(CompareMotions, AgreesWithTheTruthInAnyFrame) {
  auto poses = Walk();
  const Rigid3 moved{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {100, -50, 7}};
  for (StampedPose& stamped : poses) stamped.pose = moved * stamped.pose;
  const MotionVerdict verdict = CompareMotions(poses, Measured());
  EXPECT_EQ(verdict.contradiction, "");
  EXPECT_EQ(verdict.doubt, "");
  EXPECT_GT(verdict.num_agreeing, 0.85 * verdict.num_motions);
  EXPECT_NEAR(verdict.scale, 1, 0.02);
}

// Drift of 3 % in scale, 1 degree per second of heading, and centimetres of jitter.
TEST(CompareMotions, AgreesWithADriftingEstimate) {
  Random random(4);
  auto poses = Scaled(1.03);
  for (StampedPose& stamped : poses) {
    const double time_s = 1e-9 * static_cast<double>(stamped.time_ns);
    const Rigid3 drift{
        Eigen::Quaterniond(Eigen::AngleAxisd(0.017 * time_s, Eigen::Vector3d::UnitZ())),
        {0.02 * time_s, 0, 0}};
    stamped.pose = Perturbed(random, drift * stamped.pose, 0);
    stamped.pose.translation += NoiseOf(random, 0.01);
  }
  const MotionVerdict verdict = CompareMotions(poses, Measured());
  EXPECT_EQ(verdict.contradiction, "");
  EXPECT_EQ(verdict.doubt, "");
}

TEST(CompareMotions, LengthsInAnotherUnitAreTold) {
  EXPECT_THAT(Contradiction(Scaled(0.001)),
              ContainsRegex("multiply columns 2 to 4 by (99[0-9]|10[0-9][0-9])"));
  EXPECT_THAT(Contradiction(Scaled(1000)), ContainsRegex(kThousand));
  EXPECT_THAT(Contradiction(Scaled(0.4)), ContainsRegex("0.(39|40?)[0-9]* times"));
  const MotionVerdict verdict = CompareMotions(Scaled(0.8), Measured());
  EXPECT_EQ(verdict.contradiction, "");
  EXPECT_THAT(verdict.doubt, ContainsRegex("0.(79|80?)[0-9]* times"));
}

TEST(CompareMotions, AnotherOrderOfTheQuaternionIsTold) {
  EXPECT_THAT(Contradiction(Wxyz(Walk())), HasSubstr("write them as qx qy qz qw"));
  const std::string both = Contradiction(Wxyz(Scaled(1000)));
  EXPECT_THAT(both, HasSubstr("write them as qx qy qz qw"));
  EXPECT_THAT(both, ContainsRegex(kThousand));
}

TEST(CompareMotions, InversePosesAndAxesOfARobotAreTold) {
  auto poses = Walk();
  for (StampedPose& stamped : poses) stamped.pose = stamped.pose.Inverse();
  EXPECT_THAT(Contradiction(poses), HasSubstr("the inverses of its poses fit"));
  poses = Walk();
  Eigen::Matrix3d camera_from_robot;
  camera_from_robot << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  for (StampedPose& stamped : poses) {
    stamped.pose.rotation = stamped.pose.rotation * Eigen::Quaterniond(camera_from_robot);
  }
  EXPECT_THAT(Contradiction(poses), HasSubstr("axes are those of a robot"));
}

TEST(CompareMotions, ShiftedTimesAreDoubtedAndThenRefused) {
  for (const int later_ms : {40, -40, 100}) {
    const MotionVerdict verdict = CompareMotions(Later(later_ms * 1'000'000), Measured());
    EXPECT_EQ(verdict.contradiction, "");
    EXPECT_THAT(verdict.doubt, HasSubstr(later_ms > 0 ? "later than" : "earlier than"));
    EXPECT_THAT(verdict.doubt, ContainsRegex(later_ms == 100 ? "0.(09|10|11) s" : "0.0[345] s"));
  }
  EXPECT_THAT(Contradiction(Later(700'000'000)),
              ContainsRegex("subtract 0.(69|70|71) s from column 1"));
}

TEST(CompareMotions, PosesOfAnotherRecordingAreRefused) {
  auto poses = Walk();
  for (std::size_t i = 0; i < poses.size() / 2; ++i) {
    std::swap(poses[i].pose, poses[poses.size() - 1 - i].pose);
  }
  const MotionVerdict verdict = CompareMotions(poses, Measured());
  EXPECT_THAT(verdict.contradiction, HasSubstr("poses of the color camera of this recording"));
  NIGHTMAP_EXPECT_ERROR(DataError,
                        JudgeMotions(verdict, "x.tum"),
                        "x.tum: contradicts the recording: it agrees with");
}

TEST(CompareMotions, FewMotionsTellNothing) {
  auto measured = Measured();
  measured.resize(kMinMotions - 1);
  const MotionVerdict verdict = CompareMotions(Scaled(1000), measured);
  EXPECT_EQ(verdict.contradiction, "");
  EXPECT_EQ(verdict.num_motions, kMinMotions - 1);
  EXPECT_NO_THROW(JudgeMotions(verdict, "x.tum"));
}

TEST(MeasureMotions, MeasuresDescribedFramesWithAPoseAtAnyNumberOfThreads) {
  LandmarkScene scene = MakeLandmarkScene();
  TrackFrom(2, 3, &scene);
  auto given = scene.poses;
  given.erase(given.begin() + 5);
  const auto motions = MeasureMotions(scene.Input(), given, 1, NoProgress());
  const auto again = MeasureMotions(scene.Input(), given, 4, NoProgress());
  ASSERT_EQ(motions.size(), 5U);  // 0-1, 1-2, 2-4, 4-6, 6-7
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const auto a = TruthAt(scene.poses, motions[i].time_a_ns);
    const auto b = TruthAt(scene.poses, motions[i].time_b_ns);
    EXPECT_LT(LeftError(motions[i].b_from_a, b->Inverse() * *a).norm(), 1e-4);
    EXPECT_EQ(motions[i].b_from_a.Matrix(), again[i].b_from_a.Matrix());
  }
}

}  // namespace nightmap::motion_check_test
