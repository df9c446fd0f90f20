// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/choose_up.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "pipeline/base/random.h"
#include "stages/dense/map_frame/describe_floor.h"
#include "stages/dense/map_frame/find_map_frame.h"
#include "stages/dense/map_frame/up_candidates.h"

namespace nightmap::choose_up_test {

constexpr double kQuarter_rad = std::numbers::pi / 2;
const Eigen::Vector3d kRoom_m(7, 5, 2.6);

// How a camera is held: pitched up, and rolled so that its left comes up.
struct Held {
  double pitch_rad = -0.3;
  double roll_rad = 0;
  double turn_rad = 2 * std::numbers::pi;  // while it walks along a circle
  double walk_m = 6;
};

struct Scene {
  std::vector<SurfacePatch> patches;
  std::vector<Rigid3> given_from_cameras;
  UpInput input;
  Eigen::Vector3d up;  // in the given frame

  Eigen::Vector3d Guess() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Rigid3& pose : input.given_from_robots) {
      sum += pose.rotation * Eigen::Vector3d::UnitZ();
    }
    return AlignToSurfaces(patches, sum.normalized());
  }
  UpChoice Choose() const {
    return ChooseUp(
        patches, given_from_cameras, input.given_from_robots, input.is_mount_stated, Guess());
  }
};

bool IsNearWall(const Eigen::Vector3d& point) {
  constexpr double kNear_m = 0.9;
  return std::min({point.x(), point.y(), kRoom_m.x() - point.x(), kRoom_m.y() - point.y()}) <
         kNear_m;
}

// The surface that a ray meets first in a room that is a box, with tables along its walls.
SurfacePatch Meet(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  constexpr double kTable_m = 0.75;
  double nearest = std::numeric_limits<double>::infinity();
  SurfacePatch patch;
  for (int axis = 0; axis < 3; ++axis) {
    if (ray[axis] == 0) continue;
    const double distance = ((ray[axis] > 0 ? kRoom_m[axis] : 0) - from[axis]) / ray[axis];
    if (distance >= nearest) continue;
    nearest = distance;
    patch.point = from + distance * ray;
    patch.normal = (ray[axis] > 0 ? -1 : 1) * Eigen::Vector3d::Unit(axis);
  }
  const double to_table = ray.z() < 0 ? (kTable_m - from.z()) / ray.z() : nearest;
  if (to_table < nearest && IsNearWall(from + to_table * ray)) {
    nearest = to_table;
    patch.point = from + to_table * ray;
    patch.normal = Eigen::Vector3d::UnitZ();
  }
  const double cosine = std::max(0.1, -patch.normal.dot(ray.normalized()));
  patch.area_m2 = 0.002 * nearest * nearest / cosine;
  return patch;
}

void Look(const Rigid3& pose, int camera_idx, Random& random, std::vector<SurfacePatch>* patches) {
  for (int y = -8; y <= 8; ++y) {
    for (int x = -11; x <= 11; ++x) {
      const Eigen::Vector3d ray = pose.rotation * Eigen::Vector3d(0.05 * x, 0.05 * y, 1);
      SurfacePatch patch = Meet(pose.translation, ray);
      if ((patch.point - pose.translation).norm() > 4.5) continue;
      const Eigen::Vector3d noise(random.Gaussian(), random.Gaussian(), random.Gaussian());
      patch.point += 0.01 * random.Gaussian() * ray;
      patch.normal = (patch.normal + 0.03 * noise).normalized();
      patch.camera_idx = camera_idx;
      patches->push_back(patch);
    }
  }
}

// A walk on a circle around the room's middle, in a given frame that is turned at random.
Scene Walk(const Held& held, std::uint64_t seed) {
  constexpr int kNumCameras = 30;
  Random random(seed);
  Scene scene;
  const Eigen::Quaterniond given_from_room(Eigen::AngleAxisd(
      random.Uniform(0, 3), Eigen::Vector3d(random.Gaussian(), random.Gaussian(), 1).normalized()));
  scene.up = given_from_room * Eigen::Vector3d::UnitZ();
  const Eigen::Quaterniond robot_from_camera(0.5, -0.5, 0.5, -0.5);
  for (int i = 0; i < kNumCameras; ++i) {
    const double way = static_cast<double>(i) / kNumCameras;
    const double circle_rad = 2 * std::numbers::pi * way;
    const double radius_m = held.walk_m / (2 * std::numbers::pi);
    const Eigen::Quaterniond room_from_robot =
        Eigen::AngleAxisd(held.turn_rad * way + 0.2, Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(-held.pitch_rad + 0.05 * random.Gaussian(), Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(held.roll_rad + 0.03 * random.Gaussian(), Eigen::Vector3d::UnitX());
    const Rigid3 room_from_camera{room_from_robot * robot_from_camera,
                                  {kRoom_m.x() / 2 + radius_m * std::cos(circle_rad),
                                   kRoom_m.y() / 2 + radius_m * std::sin(circle_rad),
                                   1.4 + 0.03 * random.Gaussian()}};
    Look(room_from_camera, i, random, &scene.patches);
    const Rigid3 given_from_room_pose{given_from_room, {1, 2, 3}};
    scene.given_from_cameras.push_back(given_from_room_pose * room_from_camera);
    scene.input.given_from_robots.push_back(
        scene.given_from_cameras.back() *
        Rigid3{robot_from_camera.conjugate(), Eigen::Vector3d::Zero()});
  }
  for (SurfacePatch& patch : scene.patches) {
    patch.point = given_from_room * patch.point + Eigen::Vector3d(1, 2, 3);
    patch.normal = given_from_room * patch.normal;
  }
  return scene;
}

double Off_deg(const Scene& scene, const Eigen::Vector3d& up) {
  return Angle_rad(scene.up, up) * 180 / std::numbers::pi;
}

TEST(ChooseUp, KeepsTheGuessOfAnUprightCamera) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = Walk({}, seed);
    const UpChoice choice = scene.Choose();
    EXPECT_TRUE(choice.is_first) << seed;
    EXPECT_TRUE(choice.IsSure()) << choice.odds << ' ' << choice.next_direction;
    EXPECT_EQ(choice.direction, "the top of the picture");
    EXPECT_LT(Off_deg(scene, choice.up), 1);
  }
}

TEST(ChooseUp, FindsACameraOnItsSide) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    for (const double side : {-1.0, 1.0}) {
      const Scene scene = Walk({.roll_rad = side * kQuarter_rad, .turn_rad = 2}, seed);
      const UpChoice choice = scene.Choose();
      EXPECT_FALSE(choice.is_first) << seed;
      EXPECT_TRUE(choice.IsSure()) << choice.odds << ' ' << choice.next_direction;
      EXPECT_EQ(choice.direction,
                side > 0 ? "the left of the picture" : "the right of the picture");
      EXPECT_LT(Off_deg(scene, choice.up), 1);
    }
  }
}

// The guess is 46 degrees off, and nothing that faces up is seen.
TEST(ChooseUp, FindsUpWhereNoFloorIsSeen) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene = Walk({.pitch_rad = 0.8}, seed);
    const UpChoice choice = scene.Choose();
    EXPECT_TRUE(Off_deg(scene, choice.up) < 2 || !choice.IsSure()) << Off_deg(scene, choice.up);
    EXPECT_LT(std::min(Off_deg(scene, choice.up), 180 - Off_deg(scene, choice.up)), 2);
  }
}

// Nothing tells a camera on its side that stands still from an upright one before another wall.
TEST(ChooseUp, IsNotSureOfACameraOnItsSideThatStandsStill) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene =
        Walk({.pitch_rad = 0, .roll_rad = kQuarter_rad, .turn_rad = 0, .walk_m = 0.1}, seed);
    const UpChoice choice = scene.Choose();
    EXPECT_TRUE(Off_deg(scene, choice.up) < 2 || !choice.IsSure()) << choice.odds;
  }
}

// Even then the site config decides, if it says how the camera is mounted.
TEST(ChooseUp, TakesTheStatedMount) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Scene scene =
        Walk({.pitch_rad = -0.2, .roll_rad = kQuarter_rad, .turn_rad = 0, .walk_m = 0.1}, seed);
    const Rigid3 camera_from_mount{
        Eigen::Quaterniond(Eigen::AngleAxisd(-kQuarter_rad, Eigen::Vector3d::UnitX())),
        Eigen::Vector3d::Zero()};
    for (Rigid3& pose : scene.input.given_from_robots) pose = pose * camera_from_mount;
    scene.input.is_mount_stated = true;
    const UpChoice choice = scene.Choose();
    EXPECT_TRUE(choice.is_first && choice.IsSure()) << choice.odds << choice.next_direction;
    EXPECT_EQ(choice.direction, "the robot's z axis");
    EXPECT_LT(Off_deg(scene, choice.up), 1);
  }
}

TEST(ChooseUp, DoubtsAMountThatContradictsAWalk) {
  Scene scene = Walk({.roll_rad = kQuarter_rad}, 1);
  scene.input.is_mount_stated = true;  // as if it were upright
  const UpChoice choice = scene.Choose();
  EXPECT_TRUE(Off_deg(scene, choice.up) < 2 || !choice.IsSure()) << choice.odds;
}

TEST(AlignToSurfaces, TurnsUpToWallsAndFloors) {
  const Scene scene = Walk({.pitch_rad = 0.8}, 3);  // walls and a ceiling
  const Eigen::AngleAxisd tilt(0.15, scene.up.unitOrthogonal());
  EXPECT_LT(Off_deg(scene, AlignToSurfaces(scene.patches, tilt * scene.up)), 0.5);
  EXPECT_EQ(AlignToSurfaces({}, scene.up), scene.up);
}

TEST(AlignToSurfaces, NeedsNoLevelSurface) {
  Scene scene = Walk({}, 4);
  std::erase_if(scene.patches, [&](const SurfacePatch& patch) {
    return std::abs(patch.normal.dot(scene.up)) > 0.5;
  });
  const Eigen::AngleAxisd tilt(0.15, scene.up.unitOrthogonal());
  EXPECT_LT(Off_deg(scene, AlignToSurfaces(scene.patches, tilt * scene.up)), 0.5);
}

TEST(FindMapFrame, StandsACameraOnItsSideUpright) {
  const Scene scene = Walk({.roll_rad = kQuarter_rad, .turn_rad = 2}, 2);
  const MapFrame frame = FindMapFrame({}, scene.patches, scene.given_from_cameras, scene.input);
  EXPECT_EQ(frame.gravity_source, "surfaces and motion");
  EXPECT_EQ(frame.floor_source, "floor plane");
  EXPECT_NEAR(frame.camera_height_m, 1.4, 0.03);
  EXPECT_GT((frame.map_from_given.rotation * scene.up).z(), std::cos(0.01));
  EXPECT_TRUE(FloorWarnings(frame).empty());
}

TEST(UpWarning, NamesBothDirectionsWhereUpIsDoubtful) {
  MapFrame frame;
  EXPECT_EQ(UpWarning(frame), "");
  frame.up_odds = kSureOfUp;
  EXPECT_EQ(UpWarning(frame), "");
  frame.up_odds = 2.0;
  frame.up_direction = "the top of the picture";
  frame.next_up_direction = "the left of the picture, 90 deg from it";
  const std::string warning = UpWarning(frame);
  EXPECT_NE(warning.find(frame.up_direction), std::string::npos);
  EXPECT_NE(warning.find(frame.next_up_direction), std::string::npos);
  EXPECT_EQ(Summarize(frame).at("up_odds"), 2.0);
  EXPECT_EQ(Summarize(frame).at("up_warning"), warning);
}

}  // namespace nightmap::choose_up_test
