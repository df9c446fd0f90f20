// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/bundle_adjustment.h"

#include <limits>

#include "pipeline/base/random.h"
#include "tests/failing_cholmod.h"
#include "tests/test_data.h"

namespace nightmap::bundle_adjustment_test {

const Camera kCamera{640, 480, 525, 525, 319.5, 239.5};

// Cameras moving sideways in front of a cloud of points, all observations exact.
BundleProblem ExactProblem() {
  Random random(1);
  BundleProblem problem;
  for (int i = 0; i < 5; ++i) {
    problem.camera_from_world.push_back(
        {Eigen::Quaterniond(Eigen::AngleAxisd(0.05 * i, Eigen::Vector3d::UnitY())),
         {-0.1 * i, 0.02 * i, 0}});
    problem.cameras.push_back(kCamera);
    problem.is_fixed.push_back(i == 0);
  }
  for (int k = 0; k < 100; ++k) {
    problem.points_in_world.push_back(
        {random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(2, 4)});
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector3d p =
          problem.camera_from_world[static_cast<std::size_t>(i)] * problem.points_in_world.back();
      problem.observations.push_back({i, k, *kCamera.ProjectUndistorted(p), p.z(), DepthNoise{}});
    }
  }
  return problem;
}

// Lets a test ignore the summary.
BundleSummary Adjust(const BundleOptions& options, BundleProblem* problem) {
  return AdjustBundle(options, problem);
}

double Moved_m(const BundleProblem& problem, const BundleProblem& truth, std::size_t pose) {
  return (problem.camera_from_world[pose].translation - truth.camera_from_world[pose].translation)
      .norm();
}

// A point on the axis of the first camera, which no step may bring nearer.
void AddStuckPoint(double distance_m, double depth_m, BundleProblem* problem) {
  const int stuck = static_cast<int>(problem->points_in_world.size());
  problem->points_in_world.emplace_back(0, 0, distance_m);
  problem->observations.push_back({0, stuck, {319.5, 239.5}, depth_m, DepthNoise{}});
}

TEST(BundleAdjustment, ExactProblemStays) {
  BundleProblem problem = ExactProblem();
  const BundleSummary summary = Adjust({}, &problem);
  EXPECT_LT(summary.initial_cost, 1e-12);
  EXPECT_EQ(summary.end, BundleEnd::kConverged);
}

TEST(BundleAdjustment, ReturnsFromADisturbedStart) {
  const BundleProblem truth = ExactProblem();
  BundleProblem problem = truth;
  Random random(2);
  const auto noise = [&] {
    return Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian());
  };
  for (std::size_t i = 1; i < problem.camera_from_world.size(); ++i) {
    problem.camera_from_world[i].translation += 0.02 * noise();
  }
  for (Eigen::Vector3d& point : problem.points_in_world) point += 0.02 * noise();
  const BundleSummary summary = Adjust({.max_iterations = 50}, &problem);
  EXPECT_LT(summary.final_cost, 1e-3 * summary.initial_cost);
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    EXPECT_LT(Moved_m(problem, truth, i), 1e-3);
    EXPECT_LT(AngleBetween_rad(problem.camera_from_world[i], truth.camera_from_world[i]), 1e-3);
  }
}

// Only what lies between the cameras is measured, so where the world's origin is does not matter.
TEST(BundleAdjustment, MovingTheWorldChangesNothing) {
  const Rigid3 moved_from_world{
      Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, -1).normalized())),
      {4, -5, 6}};
  Random random(4);
  BundleProblem problem = ExactProblem();
  for (BundleObservation& o : problem.observations) {
    o.pixel += Eigen::Vector2d(random.Gaussian(), random.Gaussian());
    o.depth_m += 0.01 * random.Gaussian();
  }
  BundleProblem moved = problem;
  for (Rigid3& pose : moved.camera_from_world) pose = pose * moved_from_world.Inverse();
  for (Eigen::Vector3d& point : moved.points_in_world) point = moved_from_world * point;
  Adjust({.max_iterations = 50}, &problem);
  Adjust({.max_iterations = 50}, &moved);
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    const Rigid3 back = moved.camera_from_world[i] * moved_from_world;
    EXPECT_LT((back.Matrix() - problem.camera_from_world[i].Matrix()).norm(), 1e-4);
  }
}

// The second of two sensors measures 3 % short, of the points that both see.
TEST(BundleAdjustment, FindsTheDepthScaleOfTheSecondSensor) {
  BundleProblem problem = ExactProblem();
  problem.calibrations = {{}, {}};
  problem.sensor_idx = {0, 0, 0, 1, 1};
  for (BundleObservation& o : problem.observations) {
    if (o.pose_idx >= 3) o.depth_m *= 0.97;
  }
  BundleProblem ignored = problem;
  Adjust({.max_iterations = 50, .depth = DepthCalibration::kScale}, &problem);
  EXPECT_EQ(problem.calibrations[0].depth_scale, 1);
  EXPECT_NEAR(problem.calibrations[1].depth_scale, 1 / 0.97, 1e-4);
  EXPECT_EQ(problem.calibrations[1].focal_scale, 1) << "was not asked for";
  EXPECT_EQ(problem.calibrations[1].readout_s, 0);
  const BundleProblem truth = ExactProblem();
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_LT(Moved_m(problem, truth, i), 1e-3);
  }
  Adjust({.max_iterations = 50}, &ignored);
  EXPECT_EQ(ignored.calibrations[1].depth_scale, 1);
  EXPECT_GT(Moved_m(ignored, truth, 4), 5e-3);
}

// An offset bends the map, so parallax tells it.
TEST(BundleAdjustment, FindsTheOffsetOfDepth) {
  for (const double offset_m : {-0.08, 0.0, 0.12}) {
    BundleProblem problem = ExactProblem();
    for (BundleObservation& o : problem.observations) {
      if (o.depth_m > 0) o.depth_m += offset_m;
    }
    Adjust({.max_iterations = 50}, &problem);
    const DepthOffsets found = EstimateDepthOffsets({}, problem);
    ASSERT_EQ(found.offset_m.size(), 1U);
    EXPECT_NEAR(found.offset_m[0], offset_m, 0.005);
    EXPECT_LT(found.sigma_m[0], 0.04);
  }
}

// Cameras that only turn see the same pixels whatever the distance along the rays.
TEST(BundleAdjustment, TheOffsetOfATurningCameraIsNotKnown) {
  BundleProblem problem = ExactProblem();
  const Rigid3 first = problem.camera_from_world[0];
  const double with_parallax_m = EstimateDepthOffsets({}, problem).sigma_m[0];
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    const double angle_rad = 0.02 * static_cast<double>(i);
    problem.camera_from_world[i] =
        Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY())), {}} *
        first;
  }
  for (BundleObservation& o : problem.observations) {
    const Eigen::Vector3d p = problem.camera_from_world[static_cast<std::size_t>(o.pose_idx)] *
                              problem.points_in_world[static_cast<std::size_t>(o.point_idx)];
    o.pixel = *problem.cameras[static_cast<std::size_t>(o.pose_idx)].ProjectUndistorted(p);
    o.depth_m = p.z();
  }
  EXPECT_GT(EstimateDepthOffsets({}, problem).sigma_m.at(0), 4 * with_parallax_m);
}

// A common scale is the size of the map: nothing a single sensor sees tells it.
TEST(BundleAdjustment, TheScaleOfOneSensorIsNotObservable) {
  BundleProblem problem = ExactProblem();
  for (BundleObservation& o : problem.observations) o.depth_m *= 0.97;
  Adjust({.max_iterations = 50, .depth = DepthCalibration::kScale}, &problem);
  EXPECT_EQ(problem.calibrations[0].depth_scale, 1);
}

// Observations of a moving camera whose focal length is 1 % longer than configured and whose rows
// are read one after the other in 25 ms.
BundleProblem RollingProblem() {
  constexpr double kFocalScale = 1.01;
  constexpr double kReadout_s = 0.025;
  BundleProblem problem = ExactProblem();
  problem.motions.resize(problem.camera_from_world.size());
  for (std::size_t i = 0; i < problem.motions.size(); ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    problem.motions[i] = {{0.2 * sign, 0.8 * sign, 0.1}, {0.3, 0.1 * sign, -0.2}};
  }
  for (BundleObservation& o : problem.observations) {
    const auto pose = static_cast<std::size_t>(o.pose_idx);
    const Eigen::Vector3d in_middle =
        problem.camera_from_world[pose] *
        problem.points_in_world[static_cast<std::size_t>(o.point_idx)];
    const PointMotion& motion = problem.motions[pose];
    for (int step = 0; step < 20; ++step) {  // the row tells when, and when tells the row
      const double time_s = kReadout_s * (o.pixel.y() / (kCamera.height - 1) - 0.5);
      const Eigen::Vector3d p =
          in_middle + time_s * (motion.angular_rad_per_s.cross(in_middle) + motion.linear_m_per_s);
      o.pixel = {kFocalScale * kCamera.fx * p.x() / p.z() + kCamera.cx,
                 kFocalScale * kCamera.fy * p.y() / p.z() + kCamera.cy};
      o.depth_m = p.z();
    }
  }
  return problem;
}

TEST(BundleAdjustment, FindsFocalLengthAndRollingShutter) {
  BundleProblem problem = RollingProblem();
  BundleProblem ignored = problem;
  Adjust({.max_iterations = 100, .calibrate = true, .focal_scale_sigma = 1}, &problem);
  EXPECT_NEAR(problem.calibrations[0].focal_scale, 1.01, 1e-4);
  EXPECT_NEAR(problem.calibrations[0].readout_s, 0.025, 2e-4);
  EXPECT_EQ(problem.calibrations[0].depth_scale, 1);
  for (const BundleObservation& o : problem.observations) {
    EXPECT_LT(ReprojectionError_px(problem, o), 0.05);
  }
  const BundleProblem truth = ExactProblem();
  EXPECT_LT(Moved_m(problem, truth, 4), 1e-3);
  Adjust({.max_iterations = 50}, &ignored);
  EXPECT_EQ(ignored.calibrations[0].focal_scale, 1);
  EXPECT_GT(Moved_m(ignored, truth, 4), 3e-3);
}

// A camera that stands still does not determine its readout, so the prior stays.
TEST(BundleAdjustment, TheReadoutOfAStillCameraIsNotInvented) {
  BundleProblem problem = ExactProblem();
  Adjust({.max_iterations = 50, .calibrate = true}, &problem);
  EXPECT_NEAR(problem.calibrations[0].readout_s, 0, 1e-12);
  EXPECT_NEAR(problem.calibrations[0].focal_scale, 1, 1e-9);
}

// Half of the observations of some points are 30 px off.
TEST(BundleAdjustment, CauchysLossForgetsOutliersBetterThanHubers) {
  const BundleProblem truth = ExactProblem();
  const auto error_m = [&](RobustLoss loss) {
    BundleProblem problem = truth;
    for (std::size_t i = 0; i < problem.observations.size(); i += 9) {
      problem.observations[i].pixel += Eigen::Vector2d(30, -20);
    }
    Adjust({.loss = loss, .max_iterations = 100}, &problem);
    return Moved_m(problem, truth, 4);
  };
  EXPECT_LT(error_m(RobustLoss::kCauchy), 0.5 * error_m(RobustLoss::kHuber));
}

TEST(BundleAdjustment, TheErrorOfAPointBehindTheCameraIsInfinite) {
  BundleProblem problem = ExactProblem();
  EXPECT_LT(ReprojectionError_px(problem, problem.observations[7]), 1e-9);
  problem.observations[7].pixel += Eigen::Vector2d(3, 4);
  problem.observations[7].pixel_sigma_px = 0.3;
  EXPECT_NEAR(ReprojectionError_px(problem, problem.observations[7]), 5, 1e-9);
  problem.points_in_world[static_cast<std::size_t>(problem.observations[7].point_idx)].z() = -2;
  EXPECT_EQ(ReprojectionError_px(problem, problem.observations[7]),
            std::numeric_limits<double>::infinity());
}

TEST(BundleAdjustment, FixedPoseDoesNotMove) {
  BundleProblem problem = ExactProblem();
  problem.points_in_world[0].x() += 0.1;
  const Rigid3 before = problem.camera_from_world[0];
  Adjust({}, &problem);
  EXPECT_EQ(before.Matrix(), problem.camera_from_world[0].Matrix());
}

TEST(BundleAdjustment, SameBytesAtAnyNumberOfThreads) {
  Random random(6);
  BundleProblem problem = RollingProblem();
  for (BundleObservation& o : problem.observations) {
    o.pixel += Eigen::Vector2d(random.Gaussian(), random.Gaussian());
  }
  BundleProblem parallel = problem;
  const auto by_one = Adjust({.calibrate = true, .num_threads = 1}, &problem);
  const auto by_four = Adjust({.calibrate = true, .num_threads = 4}, &parallel);
  EXPECT_EQ(by_one.final_cost, by_four.final_cost);
  EXPECT_EQ(problem.calibrations[0].focal_scale, parallel.calibrations[0].focal_scale);
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    EXPECT_EQ(problem.camera_from_world[i].Matrix(), parallel.camera_from_world[i].Matrix());
  }
  EXPECT_EQ(problem.points_in_world, parallel.points_in_world);
}

TEST(BundleAdjustment, RefusesWhatIsNoNumberOrDoesNotFit) {
  const auto expect = [](const std::string& text, void (*damage)(BundleProblem&)) {
    BundleProblem problem = ExactProblem();
    damage(problem);
    NIGHTMAP_EXPECT_ERROR(DataError, Adjust({}, &problem), text);
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect("", [](auto& problem) { problem.observations[7].pixel.x() = kNan; });
  expect("", [](auto& problem) { problem.observations[7].depth_m = kNan; });
  expect("pose 3 is no number",
         [](auto& problem) { problem.camera_from_world[3].translation.x() = kNan; });
  expect("point 5 is no number", [](auto& problem) {
    problem.points_in_world[5].z() = std::numeric_limits<double>::infinity();
  });
  expect("", [](auto& problem) { problem.is_fixed.pop_back(); });
  expect("", [](auto& problem) { problem.sensor_idx = {0, 0, 1, 0, 0}; });
  expect("", [](auto& problem) { problem.motions.resize(2); });
}

BundleProblem DisturbedProblem() {
  BundleProblem problem = ExactProblem();
  for (std::size_t k = 0; k < problem.points_in_world.size(); ++k) {
    problem.points_in_world[k].x() += k % 2 == 0 ? 0.02 : -0.02;
  }
  return problem;
}

TEST(BundleAdjustment, SaysHowItEnded) {
  BundleProblem problem = DisturbedProblem();
  const BundleSummary one_step = Adjust({.max_iterations = 1}, &problem);
  EXPECT_EQ(one_step.end, BundleEnd::kMaxIterations);
  EXPECT_EQ(one_step.num_iterations, 1);
  EXPECT_EQ(one_step.num_accepted, 1);
  EXPECT_LT(one_step.final_cost, one_step.initial_cost);
  EXPECT_EQ(Adjust({.max_iterations = 100}, &problem).end, BundleEnd::kConverged);
  problem.observations.clear();
  EXPECT_EQ(Adjust({}, &problem).end, BundleEnd::kNothingSeen);
}

// The factor of the poses does not fit: no shorter step would help, and the poses stay unadjusted.
TEST(BundleAdjustment, WithoutMemoryItIsAnErrorAndNoRefusedStep) {
  BundleProblem problem = DisturbedProblem();
  const FailingCholmod without_memory(2000);
  NIGHTMAP_EXPECT_ERROR(DataError, Adjust({}, &problem), "does not fit into memory");
}

// A point at the nearest distance that counts as seen: by any step of some length it comes nearer,
// and the cost is infinite.
TEST(BundleAdjustment, NoStepThatLowersTheCostIsAnError) {
  BundleProblem problem = DisturbedProblem();
  AddStuckPoint(Reprojection::kMinDepth_m, 0.02, &problem);
  NIGHTMAP_EXPECT_ERROR(DataError, Adjust({}, &problem), "none of 20 steps lowered the cost");
}

// The same stall after successful steps.
TEST(BundleAdjustment, IsToldWhenItStalls) {
  BundleProblem problem = DisturbedProblem();
  AddStuckPoint(2 * Reprojection::kMinDepth_m, 0.0001, &problem);
  const BundleSummary summary = Adjust({.max_iterations = 200}, &problem);
  EXPECT_EQ(summary.end, BundleEnd::kStalled);
  EXPECT_GT(summary.num_accepted, 0);
  EXPECT_LT(summary.num_iterations, 200);
}

TEST(BundleAdjustment, LeavesOutWhatIsBehindTheCamera) {
  const BundleProblem truth = ExactProblem();
  BundleProblem problem = truth;
  problem.points_in_world.push_back({0, 0, -2});
  const int behind = static_cast<int>(problem.points_in_world.size()) - 1;
  problem.observations.push_back({2, behind, {300, 200}, 2.0, DepthNoise{}});
  Adjust({}, &problem);
  EXPECT_EQ(problem.observations.size(), truth.observations.size());
  EXPECT_LT((problem.camera_from_world[2].Matrix() - truth.camera_from_world[2].Matrix()).norm(),
            1e-6);
}

}  // namespace nightmap::bundle_adjustment_test
