// SPDX-License-Identifier: Apache-2.0
// The upward camera of the robot, and the drive of all its sensors.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "pipeline/base/files.h"
#include "pipeline/world/robot_drive.h"
#include "stages/world/synthesize/robot_recording.h"
#include "stages/world/synthesize/write_site.h"
#include "tests/stages/world/synthesize/small_site.h"

namespace nightmap::upward_test {

// A robot with all sensors, whose upward camera is mounted straight and does not shake.
SynthesizeOptions RobotSite() {
  SynthesizeOptions options = SmallSite();
  options.camera.color_noise_levels = 0;
  options.route.num_frames = 150;
  options.route.length_ratio = 0.25;
  options.route.overlap_m = 0;
  options.route.differential_drive = true;
  options.queries.num_queries = 2;
  options.upward = {10, 80, 60, 40, {0.35, 0, 0}};
  options.scanner.rate_hz = 10;
  options.scanner.start_s = 0.03;
  options.scanner.num_beams = 20;
  return options;
}

const SynthesizePlan& PlannedRobot() {
  static const SynthesizePlan plan = PlanSynthesize(RobotSite(), 2);
  return plan;
}

std::vector<ColorImage> UpwardPictures(int num_threads) {
  std::vector<ColorImage> pictures(PlannedRobot().upward.size());
  Progress progress("test", false);
  const auto sink = [&](std::size_t idx, const ColorImage& picture) { pictures[idx] = picture; };
  RunUpward(RobotSite(), PlannedRobot(), sink, progress, num_threads);
  return pictures;
}

RobotDrive DriveOf(const SynthesizeOptions& options) {
  return PlanDrive(PlannedRobot().world.layout, options.route, options.frame_rate_hz);
}

int Brightness(const ColorImage& picture, const Eigen::Vector2d& pixel) {
  const auto x = static_cast<std::size_t>(std::lround(pixel.x()));
  const auto y = static_cast<std::size_t>(std::lround(pixel.y()));
  return picture.pixels[3 * (y * static_cast<std::size_t>(picture.width) + x)];
}

// Lamps are the brightest of a ceiling, and stand where the mounting puts them: what is ahead of
// the robot is right in the picture, what is to its left is below the middle.
TEST(UpwardCamera, ShowsLampsAtTheirPlaces) {
  const SynthesizeOptions options = RobotSite();
  const RobotDrive drive = DriveOf(options);
  const std::vector<ColorImage> pictures = UpwardPictures(2);
  const Camera camera = options.upward.Pinhole();
  int num_seen = 0;
  for (std::size_t i = 0; i < pictures.size(); i += 3) {
    const RoutePoint robot = drive.At((static_cast<double>(i) + 0.5) / options.upward.rate_hz);
    for (const Lamp& lamp : PlannedRobot().world.scene.lamps) {
      const Rigid3 robot_from_building = RobotPose(robot).Inverse();
      const Eigen::Vector3d in_robot = robot_from_building * lamp.center;
      if (in_robot.head<2>().norm() > 0.9) continue;  // nothing stands between
      const double px_per_m = camera.fx / (lamp.center.z() - 0.005 - 0.35);
      const Eigen::Vector2d center(camera.cx, camera.cy);
      const Eigen::Vector2d pixel = center + px_per_m * in_robot.head<2>();
      EXPECT_GT(Brightness(pictures[i], pixel), 200);
      const Eigen::Vector3d beside_in_robot =
          robot_from_building * Eigen::Vector3d(lamp.center + Eigen::Vector3d(0.36, 0, 0));
      const Eigen::Vector2d beside = center + px_per_m * beside_in_robot.head<2>();
      EXPECT_LT(Brightness(pictures[i], beside), Brightness(pictures[i], pixel) - 20);
      ++num_seen;
    }
  }
  EXPECT_GT(num_seen, 10);
}

TEST(UpwardCamera, PicturesDoNotDependOnThreads) {
  const std::vector<ColorImage> one = UpwardPictures(1);
  const std::vector<ColorImage> four = UpwardPictures(4);
  ASSERT_EQ(one.size(), four.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].pixels, four[i].pixels) << i;
}

// Each upward picture lies between two frames, and scans coincide with neither.
TEST(UpwardCamera, TimesInterleaveWithTheFrames) {
  const SynthesizePlan& plan = PlannedRobot();
  ASSERT_EQ(plan.upward.size(), plan.frames.size() - 1);
  for (std::size_t i = 0; i < plan.upward.size(); ++i) {
    EXPECT_LT(plan.frames[i].time_ns, plan.upward[i].time_ns);
    EXPECT_LT(plan.upward[i].time_ns, plan.frames[i + 1].time_ns);
  }
  const RobotRecording recording = RecordRobot(RobotSite(), plan, 2);
  std::set<std::int64_t> times_ns;
  for (const RobotScan& scan : recording.scans) times_ns.insert(scan.time_ns);
  for (const auto* pictures : {&plan.frames, &plan.upward}) {
    for (const StampedPose& picture : *pictures) {
      EXPECT_TRUE(times_ns.insert(picture.time_ns).second) << picture.time_ns;
    }
  }
  ASSERT_EQ(recording.truth.size(), times_ns.size());
  EXPECT_TRUE(std::equal(times_ns.begin(),
                         times_ns.end(),
                         recording.truth.begin(),
                         [](std::int64_t a, const StampedPose& b) { return a == b.time_ns; }));
}

// A fixed pose on the robot gives the poses of either camera.
TEST(UpwardCamera, BothCamerasAreFixedToTheRobot) {
  const RobotRecording recording = RecordRobot(RobotSite(), PlannedRobot(), 2);
  std::map<std::int64_t, Rigid3> building_from_robot;
  for (const StampedPose& robot : recording.truth) building_from_robot[robot.time_ns] = robot.pose;
  for (const auto* pictures : {&PlannedRobot().frames, &PlannedRobot().upward}) {
    const auto on_robot = [&](const StampedPose& picture) {
      return building_from_robot.at(picture.time_ns).Inverse() * picture.pose;
    };
    const Rigid3 first = on_robot(pictures->front());
    for (const StampedPose& picture : *pictures) {
      EXPECT_LT((on_robot(picture).translation - first.translation).norm(), 1e-6);
      EXPECT_LT(AngleBetween_rad(on_robot(picture), first), 1e-6);
    }
  }
}

// The way between two moments leads to where the robot heads in their middle.
TEST(DifferentialDrive, TheRobotDoesNotSlideToTheSide) {
  const SynthesizeOptions options = RobotSite();
  const RobotDrive drive = DriveOf(options);
  constexpr double kStep_s = 0.1;
  for (double time_s = 0; time_s + kStep_s <= drive.Duration_s(); time_s += kStep_s) {
    const Eigen::Vector2d way = drive.At(time_s + kStep_s).position - drive.At(time_s).position;
    const double heading_rad = drive.At(time_s + kStep_s / 2).heading_rad;
    const Eigen::Vector2d ahead(std::cos(heading_rad), std::sin(heading_rad));
    EXPECT_GT(way.dot(ahead), 0);
    EXPECT_LT(std::abs(ahead.x() * way.y() - ahead.y() * way.x()), 0.002) << time_s;
  }
}

TEST(DifferentialDrive, TheDrivePassesEveryFrame) {
  const SynthesizeOptions options = RobotSite();
  const RobotDrive drive = DriveOf(options);
  const auto frames =
      SampleFrames(PlanPath(PlannedRobot().world.layout, options.route), options.route);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const RoutePoint robot = drive.At(static_cast<double>(i) / options.frame_rate_hz);
    EXPECT_LT((robot.position - frames[i].position).norm(), 1e-6);
    EXPECT_NEAR(robot.heading_rad, frames[i].heading_rad, 1e-6);
  }
}

TEST(UpwardCamera, ChangesNothingOfTheOtherFiles) {
  SynthesizeOptions options = RobotSite();
  options.upward.rate_hz = 0;
  const auto without = ListsAndTruth(options, PlanSynthesize(options, 2));
  std::map<std::string, std::string> with;
  for (const auto& [name, bytes] : ListsAndTruth(RobotSite(), PlannedRobot())) with[name] = bytes;
  ASSERT_EQ(with.size(), without.size() + 2);
  EXPECT_TRUE(with.contains("up/rgb.txt"));
  EXPECT_TRUE(with.contains("up/groundtruth.txt"));
  for (const auto& [name, bytes] : without) EXPECT_EQ(with[name], bytes) << name;
}

TEST(UpwardCamera, ItsFolderGoesWithTheOption) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / "nightmap_upward_test";
  fs::remove_all(folder);
  fs::create_directories(folder);
  SynthesizeOptions options = RobotSite();
  ClearRecording(folder / "synthesize.json", options);
  EXPECT_TRUE(fs::is_directory(folder / "up/rgb"));
  options.upward.rate_hz = 0;
  ClearRecording(folder / "synthesize.json", options);
  EXPECT_FALSE(fs::exists(folder / "up"));
  fs::remove_all(folder);
}

}  // namespace nightmap::upward_test
