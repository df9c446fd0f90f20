// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/synthetic_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/world/floor_plan.h"
#include "pipeline/world/plan_queries.h"
#include "pipeline/world/render.h"
#include "pipeline/world/route.h"

namespace nightmap::world_test {

BuildingOptions QuickBuilding() {
  BuildingOptions options;
  options.light_map_cell_m = 0.5;
  options.num_light_samples = 4;
  return options;
}

// The demo building, built once for all tests.
const SyntheticWorld& World() {
  static const SyntheticWorld world = BuildWorld(QuickBuilding(), RouteOptions{}, 2);
  return world;
}

std::vector<Rigid3> Route() {
  return PlanRoute(World().layout, RouteOptions{}, SyntheticCameraOptions{});
}

Camera TinyCamera() {
  SyntheticCameraOptions options;
  options.image_width_px = 80;
  options.image_height_px = 60;
  options.focal_length_px = 65;
  return options.Pinhole();
}

bool AreEqual(const RenderedFrame& a, const RenderedFrame& b) {
  return a.color.pixels == b.color.pixels && a.depth.pixels == b.depth.pixels &&
         a.labels.pixels == b.labels.pixels;
}

RenderedFrame View(const SyntheticWorld& world, const Rigid3& pose) {
  return Render(world, TinyCamera(), pose, DepthSensorOptions{}, 2.0, 1);
}

TEST(SyntheticWorld, IsEqualForEqualSeedsAndAnyThreads) {
  const SyntheticWorld again = BuildWorld(QuickBuilding(), RouteOptions{}, 1);
  const std::vector<Rigid3> route = Route();
  for (std::size_t i = 0; i < route.size(); i += 60) {
    EXPECT_TRUE(AreEqual(View(World(), route[i]), View(again, route[i]))) << "frame " << i;
  }
}

TEST(SyntheticRoute, APartOfItLiesOnTheWholeAndGoesOnOverItsEnd) {
  const auto whole = PlanPath(World().layout, RouteOptions{});
  RouteOptions options;
  options.num_frames = 500;
  options.start_ratio = 0.75;
  options.length_ratio = 0.5;
  options.overlap_m = 0;
  const auto part = SampleFrames(whole, options);
  const auto at = [&](double ratio) {
    return whole[static_cast<std::size_t>(ratio * static_cast<double>(whole.size()))].position;
  };
  EXPECT_LT((part.front().position - at(0.75)).norm(), 0.03);
  EXPECT_LT((part.back().position - at(0.25)).norm(), 0.5);
  for (std::size_t i = 0; i < part.size(); ++i) {
    double nearest_m = 1e9;
    for (const RoutePoint& point : whole) {
      nearest_m = std::min(nearest_m, (point.position - part[i].position).norm());
    }
    EXPECT_LT(nearest_m, 0.02);
    if (i == 0) continue;
    EXPECT_LE((part[i].position - part[i - 1].position).norm(), options.max_step_m);
    EXPECT_LE(std::abs(part[i].heading_rad - part[i - 1].heading_rad), options.max_turn_rad);
  }
}

// With mirrored corridors, their furniture and pictures look the same after half a turn about the
// building's centre.
TEST(SyntheticWorld, MirroredCorridorsAreFurnishedAlike) {
  const auto count_twins = [](bool is_mirrored) {
    BuildingOptions options = QuickBuilding();
    options.mirrored_corridors = is_mirrored;
    const SyntheticWorld world = BuildWorld(options, RouteOptions{}, 2);
    const Rect2& line = world.layout.center_line;
    const Eigen::Vector2d middle((line.x0 + line.x1) / 2, (line.y0 + line.y1) / 2);
    std::vector<std::pair<Eigen::Vector2d, int>> posters;  // centre and texture
    for (const Surface& surface : world.scene.surfaces) {
      const Eigen::Vector3d centre = surface.origin + (surface.edge_u + surface.edge_v) / 2;
      const bool is_in_corridor = std::ranges::any_of(
          world.layout.corridor,
          [&](const Rect2& rect) { return rect.Contains(centre.x(), centre.y()); });
      if (is_in_corridor && surface.label == SurfaceLabel::kPoster) {
        posters.emplace_back(centre.head<2>(), surface.material.texture_idx);
      }
    }
    const auto num_twins = std::ranges::count_if(posters, [&](const auto& poster) {
      return std::ranges::any_of(posters, [&](const auto& other) {
        return (2 * middle - poster.first - other.first).norm() < 0.02 &&
               poster.second == other.second;
      });
    });
    return static_cast<double>(num_twins) / static_cast<double>(posters.size());
  };
  EXPECT_GT(count_twins(true), 0.6);
  EXPECT_LT(count_twins(false), 0.3);
}

TEST(SyntheticWorld, DiffersForAnotherSeed) {
  BuildingOptions options = QuickBuilding();
  options.seed = 2;
  const SyntheticWorld other = BuildWorld(options, RouteOptions{}, 2);
  const Rigid3 pose = Route().front();
  EXPECT_NE(View(World(), pose).color.pixels, View(other, pose).color.pixels);
}

TEST(SyntheticRoute, KeepsItsDistanceToEverything) {
  for (const Rigid3& pose : Route()) {
    const Eigen::Vector2d position = pose.translation.head<2>();
    EXPECT_GE(Clearance(World().scene.boxes, position, 0.02, 1.5), 0.35);
    EXPECT_TRUE(World().layout.IsIndoors(position.x(), position.y()));
  }
}

TEST(SyntheticRoute, IsClosedAndVisitsEveryRoom) {
  const std::vector<Rigid3> route = Route();
  double to_start_m = 1e9;
  for (std::size_t i = route.size() - 30; i < route.size(); ++i) {
    to_start_m = std::min(to_start_m, (route[i].translation - route.front().translation).norm());
    EXPECT_TRUE(std::isfinite(to_start_m));
  }
  EXPECT_LT(to_start_m, 0.12);
  std::set<std::size_t> visited;
  for (const Rigid3& pose : route) {
    for (std::size_t room = 0; room < World().layout.rooms.size(); ++room) {
      const Rect2& area = World().layout.rooms[room].area;
      if (area.Contains(pose.translation.x(), pose.translation.y())) visited.insert(room);
    }
  }
  EXPECT_EQ(visited.size(), 6U);
}

// The corridor's inner walls are the ones that a camera turning into it can pass unseen.
TEST(SyntheticRoute, LooksAtTheInnerWallsOfTheCorridor) {
  const OccupancyGrid plan = TrueFloorPlan(World(), FloorPlanOptions{});
  const Camera camera = SyntheticCameraOptions{}.Pinhole();
  const std::vector<Rigid3> route = Route();
  const auto is_seen = [&](const Eigen::Vector3d& point) {
    return std::any_of(route.begin(), route.end(), [&](const Rigid3& pose) {
      const Eigen::Vector3d in_camera = pose.Inverse() * point;
      const std::optional<Eigen::Vector2d> pixel = camera.Project(in_camera);
      if (!pixel || !camera.Contains(*pixel) || in_camera.z() < 0.4 || in_camera.z() > 4.5) {
        return false;
      }
      const Eigen::Vector3d ray = point - pose.translation;
      return World().rays->Cast(pose.translation, ray.normalized()).distance >
             ray.norm() - 0.05;  // posters
    });
  };
  const Rect2 middle = World().layout.center_line;
  const double half_m = BuildingOptions{}.corridor_width_m / 2;
  int num_points = 0;
  int num_seen = 0;
  const auto check = [&](const Eigen::Vector2d& wall, const Eigen::Vector2d& outward) {
    const Eigen::Vector2d beside = wall + 0.1 * outward;
    if (plan.At(plan.CellOf(beside)) != kFreeCell) return;
    if (plan.At(plan.CellOf(wall - 0.05 * outward)) != kOccupiedCell) return;  // a doorway
    ++num_points;
    num_seen += is_seen({wall.x(), wall.y(), 0.8});
  };
  for (double x = middle.x0 + half_m + 0.05; x < middle.x1 - half_m; x += 0.1) {
    check({x, middle.y0 + half_m}, {0, -1});
    check({x, middle.y1 - half_m}, {0, 1});
  }
  for (double y = middle.y0 + half_m + 0.05; y < middle.y1 - half_m; y += 0.1) {
    check({middle.x0 + half_m, y}, {-1, 0});
    check({middle.x1 - half_m, y}, {1, 0});
  }
  EXPECT_GT(num_points, 100);
  EXPECT_GE(num_seen, 0.9 * num_points) << num_points;
}

TEST(SyntheticRoute, MovesWithinItsLimits) {
  const std::vector<Rigid3> route = Route();
  const RouteOptions options;
  for (std::size_t i = 1; i < route.size(); ++i) {
    EXPECT_LE((route[i].translation - route[i - 1].translation).norm(), options.max_step_m + 2e-3);
    EXPECT_LE(AngleBetween_rad(route[i], route[i - 1]), options.max_turn_rad + 5e-3);
  }
}

TEST(SyntheticRoute, RefusesTooFewFrames) {
  RouteOptions options;
  options.num_frames = 100;
  EXPECT_THROW(PlanRoute(World().layout, options, SyntheticCameraOptions{}), UsageError);
}

TEST(SyntheticRoute, CameraPoseHasItsAxesRight) {
  const Rigid3 pose = CameraPose({{1, 2}, 0}, 1.0, 0.1);
  EXPECT_NEAR(
      (pose.rotation * Eigen::Vector3d::UnitX() - Eigen::Vector3d(0, -1, 0)).norm(), 0, 1e-12);
  EXPECT_LT((pose.rotation * Eigen::Vector3d::UnitZ()).z(), 0);     // pitched down
  EXPECT_LT((pose.rotation * Eigen::Vector3d::UnitY()).z(), -0.9);  // y is down
}

// Rays in the height band from a free place: free cells up to the hit, an occupied one at it.
TEST(SyntheticFloorPlan, AgreesWithRays) {
  const OccupancyGrid plan = TrueFloorPlan(World(), FloorPlanOptions{});
  const std::vector<Rigid3> route = Route();
  int num_checked = 0;
  for (std::size_t i = 0; i < route.size(); i += 7) {
    for (int k = 0; k < 24; ++k) {
      const double angle_rad = k * 0.2618 + 0.01;
      const Eigen::Vector3d direction(std::cos(angle_rad), std::sin(angle_rad), 0);
      const RayHit hit = World().rays->Cast(route[i].translation, direction);
      ASSERT_GE(hit.surface_idx, 0);
      const Eigen::Vector3d inside = route[i].translation + (hit.distance + 0.004) * direction;
      const Eigen::Vector2i cell = plan.CellOf(inside.head<2>());
      ASSERT_TRUE(plan.Contains(cell));
      EXPECT_EQ(plan.At(cell), kOccupiedCell) << inside.transpose();
      ++num_checked;
    }
    EXPECT_EQ(plan.At(plan.CellOf(route[i].translation.head<2>())), kFreeCell);
  }
  EXPECT_GT(num_checked, 1000);
  EXPECT_EQ(plan.At({0, 0}), kUnknownCell);
}

TEST(SyntheticQueries, AreBesideTheRouteInFreeSpace) {
  QueryOptions options;
  options.num_queries = 12;
  const std::vector<Rigid3> route = Route();
  const auto plan = [&](int num_threads) {
    return PlanQueries(
        World(), route, SyntheticCameraOptions{}, DepthSensorOptions{}, options, 1, num_threads);
  };
  const std::vector<SyntheticQuery> queries = plan(2);
  ASSERT_EQ(queries.size(), 12U);
  for (const SyntheticQuery& query : queries) {
    const Eigen::Vector3d position = query.building_from_camera.translation;
    double nearest_m = 1e9;
    for (const Rigid3& pose : route) {
      nearest_m = std::min(nearest_m, (pose.translation - position).head<2>().norm());
    }
    EXPECT_GE(nearest_m, options.min_offset_m - 1e-9);
    EXPECT_LE(nearest_m, options.max_offset_m + 1e-9);
    EXPECT_GE(Clearance(World().scene.boxes, position.head<2>(), 0.05, 1.5), options.clearance_m);
    EXPECT_GE(query.covisible_ratio, options.min_covisible_ratio);
  }
  const std::vector<SyntheticQuery> again = plan(1);
  for (std::size_t i = 0; i < queries.size(); ++i) {
    EXPECT_EQ(queries[i].building_from_camera.translation,
              again[i].building_from_camera.translation);
  }
}

TEST(SyntheticLayout, IdenticalRoomsAreFurnishedAlike) {
  const Room& a = World().layout.rooms[0];
  const Room& b = World().layout.rooms[3];
  ASSERT_EQ(a.style, b.style);
  std::vector<Box> in_a, in_b;
  for (const Box& box : World().scene.boxes) {
    const bool is_movable = box.label != SurfaceLabel::kWall && box.label != SurfaceLabel::kDoor;
    if (is_movable && a.area.Contains(box.center.x(), box.center.y())) in_a.push_back(box);
    if (is_movable && b.area.Contains(box.center.x(), box.center.y())) in_b.push_back(box);
  }
  ASSERT_GT(in_a.size(), 20U);
  ASSERT_EQ(in_a.size(), in_b.size());
  const Eigen::Vector2d shift = b.ToBuilding({0, 0}) - a.ToBuilding({0, 0});
  for (std::size_t i = 0; i < in_a.size(); ++i) {
    EXPECT_NEAR((in_b[i].center - in_a[i].center).head<2>().norm(), shift.norm(), 1e-9);
  }
}

}  // namespace nightmap::world_test
