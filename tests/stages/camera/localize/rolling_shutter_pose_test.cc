// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/rolling_shutter_pose.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/random.h"

namespace nightmap::rolling_shutter_pose_test {

const Camera kCamera{640, 480, 525, 525, 319.5, 239.5};

// Projections of random points in a camera that reads its rows one after the other.
struct RolledPicture {
  Rigid3 truth{Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, -1).normalized())),
               {0.4, -0.2, 0.7}};
  std::vector<PointMatch> matches;

  explicit RolledPicture(const ReadoutMotion& motion, int num_matches = 200, double noise_px = 0) {
    Random random(5);
    while (static_cast<int>(matches.size()) < num_matches) {
      const Eigen::Vector3d in_middle = kCamera.BackProjectUndistorted(
          {random.Uniform(0, 639), random.Uniform(0, 479)}, random.Uniform(1, 4));
      Eigen::Vector2d pixel = *kCamera.ProjectUndistorted(in_middle);
      for (int i = 0; i < 20; ++i) {  // the row depends on where the point has moved to by then
        const double row = pixel.y() / (kCamera.height - 1) - 0.5;
        pixel = *kCamera.ProjectUndistorted(in_middle +
                                            row * motion.PerReadout().Velocity_m_per_s(in_middle));
      }
      pixel += noise_px * Eigen::Vector2d(random.Gaussian(), random.Gaussian());
      if (kCamera.Contains(pixel)) matches.push_back({pixel, truth.Inverse() * in_middle});
    }
  }
};

const ReadoutMotion kTurning{{0.004, -0.012, 0.006}, {0.002, 0.001, -0.002}};
// So wide that only the matches decide.
const MovingPoseOptions kUnknown{.turn_sigma_rad = 1, .shift_sigma_m = 1};

TEST(MovingPose, IsExactWhereAPoseAloneIsNot) {
  const RolledPicture picture(kTurning);
  const auto still = RefineAbsolutePose(kCamera, picture.matches, picture.truth, {});
  ASSERT_TRUE(still.has_value());
  EXPECT_GT(AngleBetween_rad(still->camera_from_world, picture.truth), 1e-3);
  const auto moving =
      RefineMovingPose(kCamera, picture.matches, still->camera_from_world, 12, kUnknown);
  ASSERT_TRUE(moving.has_value());
  EXPECT_LT(AngleBetween_rad(moving->pose.camera_from_world, picture.truth), 1e-5);
  EXPECT_LT((moving->pose.camera_from_world.translation - picture.truth.translation).norm(), 1e-5);
  EXPECT_LT((moving->motion.turn_rad - kTurning.turn_rad).norm(), 1e-4);
  EXPECT_LT((moving->motion.shift_m - kTurning.shift_m).norm(), 1e-4);
  EXPECT_EQ(moving->pose.inliers.size(), picture.matches.size());
  EXPECT_LT(moving->pose.rms_error_px, 1e-3);
}

TEST(MovingPose, OutliersHaveNoSay) {
  RolledPicture picture(kTurning);
  for (std::size_t i = 0; i < 60; ++i) picture.matches[i].pixel += Eigen::Vector2d(25, -14);
  const auto still = EstimateAbsolutePose(kCamera, picture.matches, {});
  ASSERT_TRUE(still.has_value());
  const auto moving =
      RefineMovingPose(kCamera, picture.matches, still->camera_from_world, 12, kUnknown);
  ASSERT_TRUE(moving.has_value());
  EXPECT_LT(AngleBetween_rad(moving->pose.camera_from_world, picture.truth), 1e-4);
  EXPECT_EQ(moving->pose.inliers.size(), picture.matches.size() - 60);
}

// The prior of the motion constrains a camera that stood still, so both poses are about equal.
TEST(MovingPose, ACameraThatStoodStillHasThePoseItHadWithoutMotion) {
  const RolledPicture picture({}, 200, 0.5);
  const auto still = RefineAbsolutePose(kCamera, picture.matches, picture.truth, {});
  const auto moving = RefineMovingPose(kCamera, picture.matches, picture.truth, 12, {});
  ASSERT_TRUE(still && moving);
  const Rigid3& pose = moving->pose.camera_from_world;
  EXPECT_LT(moving->motion.turn_rad.norm(), 2e-3);
  EXPECT_LT(AngleBetween_rad(pose, still->camera_from_world), 5e-4);
  EXPECT_LT(AngleBetween_rad(pose, picture.truth), 1e-3);
}

// A motion that is not known makes the pose less certain, the more the less is expected of it.
TEST(MovingPose, TheCovarianceHasTheMotionsInIt) {
  const RolledPicture picture({}, 200, 0.5);
  const auto sigma = [&](double turn_sigma_rad) {
    const MovingPoseOptions options{.turn_sigma_rad = turn_sigma_rad, .shift_sigma_m = 1e-6};
    const auto moving = RefineMovingPose(kCamera, picture.matches, picture.truth, 12, options);
    return std::sqrt(moving.value().pose.covariance.trace());
  };
  const auto still = RefineAbsolutePose(kCamera, picture.matches, picture.truth, {});
  ASSERT_TRUE(still.has_value());
  EXPECT_NEAR(sigma(1e-7) / std::sqrt(still->covariance.trace()), 1, 0.01);
  EXPECT_GT(sigma(0.01), 1.05 * sigma(1e-7));
}

TEST(MovingPose, RefusesFewerInliersThanAsked) {
  const RolledPicture picture(kTurning, 30);
  EXPECT_TRUE(RefineMovingPose(kCamera, picture.matches, picture.truth, 30, kUnknown));
  EXPECT_FALSE(RefineMovingPose(kCamera, picture.matches, picture.truth, 31, kUnknown));
  EXPECT_FALSE(RefineMovingPose(kCamera, {}, picture.truth, 1, {}));
}

// The camera as guessed, with a focal length 15 % too long.
const Camera kGuessed = kCamera.WithFocalScale(1.15);

TEST(MovingPose, FindsAFocalLengthThatIsNotKnown) {
  const RolledPicture picture(kTurning);
  MovingPoseOptions options = kUnknown;
  options.focal_sigma_ratio = 0.15;
  const auto found =
      RefineMovingPose(kCamera.WithFocalScale(1.03), picture.matches, picture.truth, 12, options);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->camera.fx / kCamera.fx, 1, 1e-3);
  EXPECT_LT((found->pose.camera_from_world.translation - picture.truth.translation).norm(), 3e-3);
}

TEST(MovingPose, StartsFromTheFocalLengthAskedFor) {
  const RolledPicture picture({}, 200, 0.5);
  MovingPoseOptions options;
  options.focal_sigma_ratio = 0.15;
  const auto found = RefineMovingPose(
      kGuessed, picture.matches, picture.truth, 12, options, kCamera.WithFocalScale(1.01));
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->camera.fx / kCamera.fx, 1, 4 * found->focal_sigma_ratio + 1e-3);
}

TEST(MovingPose, TheLessIsKnownOfTheFocalLengthTheLessSureIsThePose) {
  const RolledPicture picture({}, 30, 0.5);
  double last = 0;
  for (const double sigma_ratio : {0.0, 0.001, 0.01, 0.3}) {
    MovingPoseOptions options;
    options.focal_sigma_ratio = sigma_ratio;
    const auto found = RefineMovingPose(kCamera, picture.matches, picture.truth, 12, options);
    ASSERT_TRUE(found.has_value());
    const double sigma_m = std::sqrt(found->pose.covariance.bottomRightCorner<3, 3>().trace());
    EXPECT_GT(sigma_m, last) << sigma_ratio;
    last = sigma_m;
  }
}

}  // namespace nightmap::rolling_shutter_pose_test
