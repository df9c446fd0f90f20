// SPDX-License-Identifier: Apache-2.0
// The floor of rooms where more is seen of counters and tables than of the floor.
#include "stages/dense/map_frame/choose_floor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pipeline/base/random.h"
#include "pipeline/world/paint.h"
#include "pipeline/world/render.h"
#include "pipeline/world/route.h"
#include "stages/dense/map_frame/describe_floor.h"
#include "stages/dense/map_frame/find_map_frame.h"

namespace nightmap::choose_floor_test {

struct Slab {
  double height_m = 0;
  Rect2 rect;
};

// Level slabs side by side, the floor first: z = 0. Furniture hides no floor that counts.
struct Room {
  std::vector<Slab> slabs;
  std::vector<Rigid3> cameras;
  std::vector<SurfacePatch> patches;

  double Width_m() const { return slabs.back().rect.x1; }
};

Slab NextSlab(const Room& room, double height_m, double area_m2, Random& random) {
  const double width_m = std::sqrt(area_m2) * random.Uniform(0.8, 1.25);
  const double x0_m = room.slabs.empty() ? 0 : room.Width_m() + 0.05;
  return {height_m, {x0_m, 0, x0_m + width_m, area_m2 / width_m}};
}

Eigen::Vector3d PointOn(const Slab& slab, Random& random) {
  return {random.Uniform(slab.rect.x0, slab.rect.x1),
          random.Uniform(slab.rect.y0, slab.rect.y1),
          slab.height_m};
}

void AddPatch(const Eigen::Vector3d& point,
              const Eigen::Vector3d& normal,
              int camera_idx,
              Random& random,
              Room& room) {
  const auto noise = [&](double sigma) {
    return Eigen::Vector3d(
        sigma * Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian()));
  };
  room.patches.push_back(
      {point + noise(0.005), (normal + noise(0.02)).normalized(), 1.0 / 60, camera_idx});
}

bool Crosses(const Slab& slab, const Eigen::Vector3d& camera, const Eigen::Vector3d& point) {
  const double above_m = camera.z() - slab.height_m;
  const double below_m = slab.height_m - point.z();
  if (above_m <= 0 || below_m <= 1e-9) return false;
  const Eigen::Vector3d crossing = camera + (point - camera) * (above_m / (above_m + below_m));
  return slab.rect.Contains(crossing.x(), crossing.y());
}

// Patches that a camera sees of the slabs and of the wall behind them.
void Look(int camera_idx, Random& random, Room& room) {
  const Eigen::Vector3d camera = room.cameras[static_cast<std::size_t>(camera_idx)].translation;
  for (const Slab& slab : room.slabs) {
    if (slab.height_m >= camera.z()) continue;
    const int count = static_cast<int>(60 * slab.rect.Area());
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d point = PointOn(slab, random);
      const bool is_hidden = std::ranges::any_of(
          room.slabs, [&](const Slab& other) { return Crosses(other, camera, point); });
      if (!is_hidden) AddPatch(point, Eigen::Vector3d::UnitZ(), camera_idx, random, room);
    }
  }
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d point(random.Uniform(0, room.Width_m()), 3, random.Uniform(0, 2.5));
    AddPatch(point, -Eigen::Vector3d::UnitY(), camera_idx, random, room);
  }
}

// Returns below the floor: some anywhere, and a ceiling that the floor mirrors: one in five that
// reach the floor.
void AddReturnsBelow(int camera_idx, double ceiling_m, Random& random, Room& room) {
  const Eigen::Vector3d camera = room.cameras[static_cast<std::size_t>(camera_idx)].translation;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d point(
        random.Uniform(0, room.Width_m()), random.Uniform(0, 2), random.Uniform(-2, -0.05));
    AddPatch(point, Eigen::Vector3d::UnitZ(), camera_idx, random, room);
  }
  const int num_mirrored = static_cast<int>(15 * room.slabs[0].rect.Area());
  for (int i = 0; i < num_mirrored; ++i) {
    const Eigen::Vector3d mirror = PointOn(room.slabs[0], random);
    const Eigen::Vector3d point = mirror + (mirror - camera) * (ceiling_m / camera.z());
    if ((point - camera).norm() > 4) continue;
    AddPatch(point, Eigen::Vector3d::UnitZ(), camera_idx, random, room);
  }
}

Rigid3 CameraAt(const Eigen::Vector3d& position, double yaw_rad) {
  return CameraPose({position.head<2>(), yaw_rad}, position.z(), 0.4);
}

Room RandomRoom(Random& random) {
  Room room;
  room.slabs.push_back(NextSlab(room, 0, random.Uniform(0.3, 5), random));
  const std::size_t num_pieces = 1 + random.Index(4);
  double highest_m = 0;
  for (std::size_t i = 0; i < num_pieces; ++i) {
    const double height_m = random.Uniform(0.35, 1.1);
    room.slabs.push_back(NextSlab(room, height_m, random.Uniform(0.2, 3), random));
    highest_m = std::max(highest_m, height_m);
  }
  const double camera_m = std::max(highest_m + 0.33, random.Uniform(0.7, 1.6));
  for (int i = 0; i < 12; ++i) {
    // One in three looks from over the floor, so that all of it is seen.
    Eigen::Vector3d position =
        PointOn(room.slabs[i % 3 == 0 ? 0 : random.Index(num_pieces + 1)], random);
    position.z() = camera_m + random.Uniform(-0.03, 0.03);
    room.cameras.push_back(CameraAt(position, random.Uniform(-3, 3)));
  }
  const bool has_returns_below = random.Index(2) == 0;
  const double ceiling_m = random.Uniform(1.9, 2.6);
  for (int i = 0; i < 12; ++i) {
    Look(i, random, room);
    if (has_returns_below) AddReturnsBelow(i, ceiling_m, random, room);
  }
  return room;
}

TEST(ChooseFloor, IsTheFloorInRandomRoomsHoweverLargeTheirFurniture) {
  int num_small = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Room room = RandomRoom(random);
    const Rect2& floor = room.slabs[0].rect;
    const Eigen::Vector3d on_floor((floor.x0 + floor.x1) / 2, (floor.y0 + floor.y1) / 2, 0);
    for (const bool has_accelerometer : {false, true}) {
      UpInput up = Held(room.cameras);
      if (has_accelerometer) up.measured_in_given = Eigen::Vector3d(0.01, 0, 1).normalized();
      const MapFrame frame = FindMapFrame({}, room.patches, room.cameras, up);
      EXPECT_EQ(frame.floor_source, "floor plane");
      EXPECT_NEAR((frame.map_from_given * on_floor).z(), 0, 0.02) << floor.Area();
      EXPECT_LT(frame.below_floor_share, kMaxBelowFloorShare);
    }
    num_small += std::ranges::any_of(
                     room.slabs, [&](const Slab& slab) { return slab.rect.Area() > floor.Area(); })
                     ? 1
                     : 0;
  }
  EXPECT_GT(num_small, 80);  // rooms with more of some piece than of the floor
}

// A kitchen: a strip of floor before a counter 1.07 m high, and walls.
constexpr double kLength_m = 2.2;
constexpr double kStrip_m = 0.42;
constexpr double kCounterDepth_m = 0.5;
constexpr double kCounter_m = 1.07;

Surface Quad(const Eigen::Vector3d& origin, const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  Surface surface;
  surface.origin = origin;
  surface.edge_u = u;
  surface.edge_v = v;
  return surface;
}

SyntheticWorld Kitchen(bool has_floor) {
  const double end_m = kStrip_m + kCounterDepth_m;
  const Eigen::Vector3d along(kLength_m, 0, 0), across(0, kStrip_m, 0), up(0, 0, 2.5);
  Scene scene;
  scene.textures.emplace_back(PaintTexture(Paint::kPoster, 64, 1));
  if (has_floor) scene.surfaces.push_back(Quad({0, 0, 0}, along, across));
  scene.surfaces.push_back(Quad({0, kStrip_m, kCounter_m}, along, {0, kCounterDepth_m, 0}));
  scene.surfaces.push_back(Quad({0, kStrip_m, 0}, along, {0, 0, kCounter_m}));
  scene.surfaces.push_back(Quad({0, end_m, kCounter_m}, along, up));
  for (const double x : {0.0, kLength_m}) {
    scene.surfaces.push_back(Quad({x, 0, 0}, {0, end_m, 0}, up));
  }
  scene.lamps.push_back({{1, 0.4, 2.5}, {0.3, 0.3}, 2.0F});
  return WorldOfScene(std::move(scene));
}

// Carried along the counter, 0.33 m above its top, looking down at it and past it.
MapFrame FrameOfKitchen(bool has_floor) {
  SyntheticCameraOptions options;
  options.image_width_px = 320;
  options.image_height_px = 240;
  options.focal_length_px = 262.5;
  RgbdCamera camera;
  camera.color = options.Pinhole();
  const SyntheticWorld world = Kitchen(has_floor);
  Room room;
  for (int i = 0; i < 24; ++i) {
    const double x = 0.25 + 1.7 * i / 23;
    const RoutePoint at{{x, i % 2 == 0 ? 0.3 : 0.6}, i % 3 == 0 ? 0.0 : (i % 3 == 1 ? 3.1 : 1.0)};
    room.cameras.push_back(CameraPose(at, kCounter_m + 0.33, 0.7));
    const auto frame = Render(world,
                              camera.color,
                              room.cameras.back(),
                              DepthSensorOptions{},
                              0,
                              static_cast<std::uint64_t>(i));
    for (SurfacePatch patch : SamplePatches(frame.depth, camera, room.cameras.back(), 4)) {
      patch.camera_idx = i;
      room.patches.push_back(patch);
    }
  }
  return FindMapFrame({}, room.patches, room.cameras, Held(room.cameras));
}

TEST(ChooseFloor, IsTheFloorBesideACounterOfWhichMoreIsSeen) {
  const MapFrame frame = FrameOfKitchen(true);
  EXPECT_EQ(frame.floor_source, "floor plane");
  EXPECT_NEAR(frame.camera_height_m, kCounter_m + 0.33, 0.02);
  EXPECT_LT(frame.floor_area_m2, 1);
  EXPECT_GE(frame.floor_num_keyframes, 3);
  EXPECT_LT(frame.below_floor_share, 0.01);
  EXPECT_TRUE(FloorWarnings(frame).empty());
}

TEST(ChooseFloor, IsNoCounterWhereTheFloorWasNotSeen) {
  const MapFrame frame = FrameOfKitchen(false);
  EXPECT_EQ(frame.floor_source, "lowest points");
  EXPECT_GT(frame.camera_height_m, 0.9);  // down the front of the counter
  const auto warnings = FloorWarnings(frame);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(warnings[0].starts_with("no floor was seen")) << warnings[0];
}

// Two storeys, 3 m apart; cameras are on the upper one and see a part of the lower one.
TEST(ChooseFloor, IsTheStoreyThatTheCamerasAreOn) {
  Random random(5);
  Room room;
  room.slabs = {{-3, {0, 0, 1, 1.5}}, {0, {1.05, 0, 4, 3}}};
  for (int i = 0; i < 6; ++i) {
    room.cameras.push_back(CameraAt({random.Uniform(1.1, 1.3), random.Uniform(0, 1.5), 1.2}, 3));
    Look(i, random, room);
  }
  const MapFrame frame = FindMapFrame({}, room.patches, room.cameras, Held(room.cameras));
  EXPECT_NEAR(frame.camera_height_m, 1.2, 0.02);
  // Carried down there too, it is the lower one.
  room.cameras.push_back(CameraAt({0.5, 0.5, -1.8}, 3));
  const MapFrame below = FindMapFrame({}, room.patches, room.cameras, Held(room.cameras));
  EXPECT_NEAR(below.camera_height_m, 4.2, 0.02);
}

TEST(FloorWarnings, SayWhenMuchLiesBelow) {
  MapFrame frame;
  frame.floor_source = "floor plane";
  EXPECT_TRUE(FloorWarnings(frame).empty());
  frame.below_floor_share = 0.31;
  ASSERT_EQ(FloorWarnings(frame).size(), 1U);
  EXPECT_TRUE(
      FloorWarnings(frame)[0].starts_with("31 % of the measured points lie more than 0.3 m"));
}

TEST(DescribeFloor, SaysWhatItIs) {
  MapFrame frame;
  frame.floor_source = "floor plane";
  frame.floor_area_m2 = 0.92;
  frame.floor_num_keyframes = 12;
  frame.camera_height_m = 1.4;
  EXPECT_EQ(
      DescribeFloor(frame),
      "z = 0 is the floor plane: 0.92 m2 seen by 12 keyframes, 1.40 m below the median camera");
}

}  // namespace nightmap::choose_floor_test
