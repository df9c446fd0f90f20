// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_adjust/ceiling_problem.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/ceiling/planar_pose.h"
#include "stages/ceiling/ceiling_adjust/ceiling_errors.h"
#include "tests/failing_cholmod.h"

namespace nightmap::ceiling_problem_test {

double Uniform(Random& random, double half_width) {
  return half_width * (2 * random.Uniform() - 1);
}

// A robot that drives an arc, whose pictures and wheels are exact.
struct Drive {
  CeilingProblem problem;
  CeilingUnknowns truth;

  Drive() {
    problem.camera = {640, 480, 400, 410, 320, 240};
    Random random(7);
    for (int i = 0; i < 300; ++i) {
      truth.points.emplace_back(
          Uniform(random, 12), Uniform(random, 12), 2.6 + Uniform(random, 0.5));
    }
    Rigid2 pose;
    for (std::size_t k = 0; k < 60; ++k) {
      Vector5d& keyframe = truth.keyframes.emplace_back(Vector5d::Zero());
      keyframe.head<3>() = ToVector(pose);
      const KeyframeView view(problem, keyframe, truth.mounting);
      for (std::size_t i = 0; i < truth.points.size(); ++i) {
        const auto pixel = view.Error_px(truth.points[i], Eigen::Vector2d::Zero());
        if (pixel && pixel->x() > 0 && pixel->x() < 640 && pixel->y() > 0 && pixel->y() < 480) {
          problem.sightings.push_back({k, i, *pixel});
        }
      }
      if (k == 59) break;
      const Rigid2 moved{0.05, {0.2, 0.01}};
      problem.motions.push_back({k, moved, 0.2, 0.05, true, 1});
      pose = pose * moved;
    }
  }

  // The way turns more and more; points stay with the keyframes around.
  CeilingUnknowns Bent(double turn_rad) const {
    CeilingUnknowns bent = truth;
    const auto bend = [&](double share, Eigen::Vector2d place) -> Eigen::Vector2d {
      return Eigen::Rotation2Dd(turn_rad * share) * place;
    };
    for (std::size_t k = 0; k < bent.keyframes.size(); ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(bent.keyframes.size());
      bent.keyframes[k].head<2>() = bend(share, truth.keyframes[k].head<2>());
      bent.keyframes[k][2] += turn_rad * share;
    }
    return bent;
  }
};

CeilingSolution Solve(const CeilingProblem& problem, CeilingUnknowns* unknowns) {
  Progress progress("ceiling_adjust", false);
  return SolveCeiling({}, problem, progress, unknowns);
}

template <typename Function, typename Vector, typename Jacobian>
void ExpectDerivative(const Function& residual, const Vector& at, const Jacobian& by) {
  constexpr double kStep = 1e-6;
  for (int i = 0; i < at.size(); ++i) {
    Vector before = at, after = at;
    before[i] -= kStep;
    after[i] += kStep;
    const auto numeric = ((residual(after) - residual(before)) / (2 * kStep)).eval();
    EXPECT_LT((numeric - by.col(i)).norm(), 1e-5 * (1 + by.norm())) << i;
  }
}

TEST(CeilingProblem, DerivativesOfASighting) {
  CeilingProblem problem;
  problem.camera = {640, 480, 400, 410, 320, 240};
  problem.robot_from_camera.rotation =
      Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized());
  problem.robot_from_camera.translation = {0.1, -0.05, 0.3};
  Vector5d keyframe, mounting;
  keyframe << 1, 2, 0.7, 0.01, -0.02;
  for (const double turn_rad : {0.0, 0.05}) {
    keyframe.tail<2>() *= turn_rad > 0 ? 1 : 0;
    mounting << turn_rad, -turn_rad, 2 * turn_rad, 0.02, -0.03;
    const Eigen::Vector3d point(1.3, 2.4, 2.6);
    const Eigen::Vector2d pixel(300, 200);
    const auto error = [&](const Vector5d& k, const Vector5d& m, const Eigen::Vector3d& p) {
      return Eigen::Vector2d(*KeyframeView(problem, k, m).Error_px(p, pixel) / 0.5);
    };
    const LinearSighting linear =
        KeyframeView(problem, keyframe, mounting).Linearize(point, pixel, 0.5);
    EXPECT_LT((linear.residual - error(keyframe, mounting, point)).norm(), 1e-9);
    ExpectDerivative(
        [&](const Vector5d& k) { return error(k, mounting, point); }, keyframe, linear.by_keyframe);
    ExpectDerivative(
        [&](const Vector5d& m) { return error(keyframe, m, point); }, mounting, linear.by_mounting);
    ExpectDerivative([&](const Eigen::Vector3d& p) { return error(keyframe, mounting, p); },
                     point,
                     linear.by_point);
  }
}

TEST(CeilingProblem, DerivativesOfAMotion) {
  const KeyframeMotion motion{0, {0.3, {0.5, 0.1}}, 0.6, 0.3, true, 1};
  const Eigen::Vector3d before(1, 2, 0.4), after(1.4, 2.3, 0.8);
  const Eigen::Vector2d wheels(0.02, 0.03);
  const auto error = [&](const auto& b, const auto& a, const auto& w) {
    return LinearizeMotion({}, motion, b, a, w).residual;
  };
  const LinearMotion linear = LinearizeMotion({}, motion, before, after, wheels);
  ExpectDerivative(
      [&](const Eigen::Vector3d& b) { return error(b, after, wheels); }, before, linear.by_before);
  ExpectDerivative(
      [&](const Eigen::Vector3d& a) { return error(before, a, wheels); }, after, linear.by_after);
  ExpectDerivative(
      [&](const Eigen::Vector2d& w) { return error(before, after, w); }, wheels, linear.by_wheels);
}

TEST(CeilingProblem, ABentWayIsStraightenedInFewSteps) {
  const Drive drive;
  CeilingUnknowns unknowns = drive.Bent(0.3);
  const CeilingSolution solution = Solve(drive.problem, &unknowns);
  EXPECT_TRUE(solution.has_converged);
  EXPECT_LT(solution.final_cost, 1e-3);
  EXPECT_LT(solution.num_iterations, 20);
  for (std::size_t k = 0; k < unknowns.keyframes.size(); ++k) {
    EXPECT_LT((unknowns.keyframes[k] - drive.truth.keyframes[k]).norm(), 1e-3) << k;
  }
}

TEST(CeilingProblem, TheFirstPoseStaysAndCornersThatJumpedMoveNothing) {
  Drive drive;
  for (std::size_t i = 0; i < drive.problem.sightings.size(); i += 20) {
    drive.problem.sightings[i].pixel.x() += 60;
  }
  CeilingUnknowns unknowns = drive.Bent(0.02);
  const CeilingSolution solution = Solve(drive.problem, &unknowns);
  EXPECT_LT(solution.median_error_px, 0.1);
  EXPECT_EQ(unknowns.keyframes[0].head<3>(), drive.truth.keyframes[0].head<3>());
  for (std::size_t k = 0; k < unknowns.keyframes.size(); ++k) {
    const Eigen::Vector3d moved = (unknowns.keyframes[k] - drive.truth.keyframes[k]).head<3>();
    EXPECT_LT(moved.norm(), 0.02) << k;
  }
}

// Nothing tells how the measured level of no landmark moves, nor where an unseen point is.
TEST(CeilingProblem, WhatNothingMeasuresStays) {
  Drive drive;
  drive.truth.points.emplace_back(100, 100, 3);
  drive.truth.level_m = 2.5;
  CeilingUnknowns unknowns = drive.Bent(0.02);
  Solve(drive.problem, &unknowns);
  EXPECT_EQ(unknowns.points.back(), drive.truth.points.back());
  EXPECT_EQ(unknowns.level_m, 2.5);
}

TEST(CeilingProblem, APointBelowItsCameraIsAnError) {
  const Drive drive;
  CeilingUnknowns unknowns = drive.truth;
  unknowns.points[drive.problem.sightings[0].point].z() = -1;
  EXPECT_THROW(Solve(drive.problem, &unknowns), DataError);
}

TEST(CeilingProblem, WithoutMemoryItIsAnError) {
  const Drive drive;
  CeilingUnknowns unknowns = drive.Bent(0.02);
  const FailingCholmod without_memory(10'000);
  EXPECT_THROW(Solve(drive.problem, &unknowns), DataError);
}

}  // namespace nightmap::ceiling_problem_test
