// SPDX-License-Identifier: Apache-2.0
// The plan and the drive through it.
#include "stages/ceiling/synthesize_ceiling/ceiling_route.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/random.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_walk.h"

namespace nightmap::ceiling_route_test {

constexpr double kBlank_m = 8;
constexpr double kOverlap_m = 12;

std::vector<CeilingPlan> Plans() {
  return {PlanCeilingCorridor(kBlank_m, kOverlap_m, 1),
          PlanCeilingCorridor(0, 6, 2),
          PlanCeilingOffice(1)};
}

TEST(CeilingPlan, RectanglesDoNotOverlap) {
  for (const CeilingPlan& plan : Plans()) {
    for (std::size_t i = 0; i < plan.rects.size(); ++i) {
      EXPECT_GT(plan.rects[i].area.Area(), 0);
      for (std::size_t k = 0; k < i; ++k) {
        const Rect2& a = plan.rects[i].area;
        const Rect2& b = plan.rects[k].area;
        const double width_m = std::min(a.x1, b.x1) - std::max(a.x0, b.x0);
        const double height_m = std::min(a.y1, b.y1) - std::max(a.y0, b.y0);
        EXPECT_TRUE(width_m <= 1e-12 || height_m <= 1e-12) << i << " " << k;
      }
    }
  }
}

TEST(CeilingPlan, FittingsAreWithinTheirCeilings) {
  for (const CeilingPlan& plan : Plans()) {
    EXPECT_GT(plan.fittings.size(), 20U);
    for (const CeilingFitting& fitting : plan.fittings) {
      const CeilingRect& rect = plan.rects[static_cast<std::size_t>(fitting.rect)];
      EXPECT_GE(fitting.area.x0, rect.area.x0 - 1e-9);
      EXPECT_GE(fitting.area.y0, rect.area.y0 - 1e-9);
      EXPECT_LE(fitting.area.x1, rect.area.x1 + 1e-9);
      EXPECT_LE(fitting.area.y1, rect.area.y1 + 1e-9);
      EXPECT_NE(rect.finish, CeilingFinish::kBlank);
    }
  }
}

TEST(CeilingPlan, TwoRoomsOfTheOfficeLookTheSame) {
  const CeilingPlan plan = PlanCeilingOffice(1);
  int num_pairs = 0;
  for (std::size_t i = 0; i < plan.rects.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) num_pairs += plan.rects[i].look == plan.rects[k].look;
  }
  EXPECT_EQ(num_pairs, 1);
}

TEST(CeilingRoute, KeepsClearOfWalls) {
  constexpr double kClearance_m = 0.35;
  for (const CeilingPlan& plan : Plans()) {
    const RobotDrive drive = DriveCeilingLegs(plan.legs, {});
    for (double time_s = 0; time_s < drive.Duration_s(); time_s += 0.05) {
      ASSERT_TRUE(plan.IsFree(drive.At(time_s).position, kClearance_m)) << time_s;
    }
  }
}

TEST(CeilingRoute, TheLoopIs120mLong) {
  const CeilingPlan plan = PlanCeilingCorridor(kBlank_m, kOverlap_m, 1);
  const double length_m = RoundCorners(plan.legs[0], 0.4).back().at_m - kOverlap_m;
  EXPECT_NEAR(length_m, 120, 1.2);
}

TEST(CeilingRoute, IsDrivenByTwoWheels) {
  const CeilingRouteOptions options;
  constexpr double kStep_s = 0.005;
  for (const CeilingPlan& plan : Plans()) {
    const RobotDrive drive = DriveCeilingLegs(plan.legs, options);
    double speed_m_per_s = 0;
    for (double time_s = kStep_s; time_s < drive.Duration_s(); time_s += kStep_s) {
      const RoutePoint a = drive.At(time_s - kStep_s);
      const RoutePoint b = drive.At(time_s);
      const Eigen::Vector2d way = b.position - a.position;
      const double heading_rad = (a.heading_rad + b.heading_rad) / 2;
      const Eigen::Vector2d ahead(std::cos(heading_rad), std::sin(heading_rad));
      const double speed_now = ahead.dot(way) / kStep_s;
      ASSERT_LT(std::abs(ahead.x() * way.y() - ahead.y() * way.x()), 1e-5) << time_s;
      ASSERT_GE(speed_now, -1e-9);
      ASSERT_LT(speed_now, options.speed_m_per_s * 1.001);
      // At rest it is the mean over the first or last 5 mm.
      ASSERT_LT(std::abs(speed_now - speed_m_per_s), 0.05) << time_s;
      const double turn_rad_per_s = (b.heading_rad - a.heading_rad) / kStep_s;
      ASSERT_LT(std::abs(turn_rad_per_s), options.turn_rate_rad_per_s * 1.05) << time_s;
      speed_m_per_s = speed_now;
    }
  }
}

TEST(CeilingRoute, TheOfficeRouteEndsFacingAsAtTheStart) {
  const RobotDrive drive = DriveCeilingLegs(PlanCeilingOffice(1).legs, {});
  const RoutePoint last = drive.At(drive.Duration_s());
  EXPECT_NEAR(std::remainder(last.heading_rad - drive.At(0).heading_rad, 2 * M_PI), 0, 1e-9);
  EXPECT_EQ(drive.At(0.9).position, drive.At(0).position);
}

// Points of a ray up to its end are below ceilings; those beyond are not.
TEST(CeilingWalk, RaysEndWhereThePlanEnds) {
  constexpr double kTiny = 1e-4;
  Random random(3);
  for (const CeilingPlan& plan : Plans()) {
    const CeilingWalk walk(plan);
    const RobotDrive drive = DriveCeilingLegs(plan.legs, {});
    const auto is_open = [&plan](const Eigen::Vector3d& point) {
      const int rect = plan.RectAt(point.x(), point.y());
      return rect >= 0 && point.z() < plan.rects[static_cast<std::size_t>(rect)].height_m;
    };
    for (int i = 0; i < 3000; ++i) {
      const Eigen::Vector2d at = drive.At(random.Uniform(0, drive.Duration_s())).position;
      const Eigen::Vector3d origin(at.x(), at.y(), 0.35);
      const Eigen::Vector3d ray(random.Uniform(-1, 1), random.Uniform(-0.8, 0.8), 1);
      const CeilingHit hit = walk.Cast(plan.RectAt(at.x(), at.y()), origin, ray);
      ASSERT_GE(hit.rect, 0);
      const Eigen::Vector3d end = origin + hit.t * ray;
      const CeilingRect& rect = plan.rects[static_cast<std::size_t>(hit.rect)];
      if (hit.face == kCeilingFace) {
        EXPECT_NEAR(end.z(), rect.height_m, 1e-9);
        EXPECT_NEAR(hit.at.x(), end.x() - rect.area.x0, 1e-9);
      } else {
        EXPECT_NEAR(hit.at.y(), end.z(), 1e-9);
      }
      for (double share = 0; share < 1; share += 0.05) {
        ASSERT_TRUE(is_open(origin + share * (hit.t - kTiny) * ray));
      }
      EXPECT_FALSE(is_open(end + kTiny * ray));
    }
  }
}

}  // namespace nightmap::ceiling_route_test
