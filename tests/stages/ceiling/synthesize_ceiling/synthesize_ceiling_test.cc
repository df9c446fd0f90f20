// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/synthesize_ceiling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <mutex>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/random.h"
#include "pipeline/recording/site_config.h"
#include "stages/ceiling/synthesize_ceiling/write_ceiling.h"

namespace nightmap::synthesize_ceiling_test {

constexpr double kLampFrame_m = 0.02;

SynthesizeCeilingOptions Small() {
  SynthesizeCeilingOptions options;
  options.image_width_px = 160;
  options.image_height_px = 120;
  options.focal_length_px = 80;
  return options;
}

const CeilingWorld& Office() {
  static const CeilingWorld world = PaintCeilingWorld(PlanCeilingOffice(1), 1, 2);
  return world;
}

const CeilingWorld& Corridor() {
  static const CeilingWorld world = PaintCeilingWorld(PlanCeilingCorridor(8, 12, 1), 1, 2);
  return world;
}

double Bilinear(const Image<float>& image, const Eigen::Vector2d& at) {
  const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
  const double fx = at.x() - x, fy = at.y() - y;
  return (1 - fy) * ((1 - fx) * image.At(x, y) + fx * image.At(x + 1, y)) +
         fy * ((1 - fx) * image.At(x, y + 1) + fx * image.At(x + 1, y + 1));
}

// How far from `expected` along `outward` (px) the brightness falls to half that of a lamp.
double EdgeError_px(const Image<float>& image,
                    const Eigen::Vector2d& expected,
                    const Eigen::Vector2d& outward) {
  const double lit = Bilinear(image, expected - 3 * outward);
  const double dark = Bilinear(image, expected + 3 * outward);
  for (double shift_px = -3; shift_px < 3; shift_px += 0.01) {
    if (Bilinear(image, expected + shift_px * outward) < (lit + dark) / 2) return shift_px;
  }
  return 3;
}

TEST(CeilingRender, EdgesOfLampsAreWhereTheyProject) {
  const Camera camera = Small().Pinhole();
  Random random(5);
  double sum_px = 0;
  int num_edges = 0;
  for (const CeilingFitting& fitting : Corridor().plan.fittings) {
    if (fitting.kind != FittingKind::kLamp) continue;
    const Rect2& area = fitting.area;
    const double height_m = Corridor().plan.rects[static_cast<std::size_t>(fitting.rect)].height_m;
    const Eigen::Vector3d middle((area.x0 + area.x1) / 2, (area.y0 + area.y1) / 2, height_m);
    const Eigen::AngleAxisd turn(random.Uniform(-0.2, 0.2), Eigen::Vector3d::UnitZ());
    const Eigen::AngleAxisd tilt(0.02, Eigen::Vector3d(0.6, 0.8, 0));
    const Rigid3 pose{
        Eigen::Quaterniond(turn * tilt),
        {middle.x() + random.Uniform(-0.3, 0.3), middle.y() + random.Uniform(-0.2, 0.2), 0.35}};
    const Image<float> image = RenderCeiling(Corridor(), camera, {pose});
    for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const Eigen::Vector3d edge =
          middle + Eigen::Vector3d(x * ((area.x1 - area.x0) / 2 - kLampFrame_m),
                                   y * ((area.y1 - area.y0) / 2 - kLampFrame_m),
                                   0);
      const auto pixel = camera.Project(pose.Inverse() * edge);
      const auto beyond = camera.Project(pose.Inverse() * (edge + Eigen::Vector3d(x, y, 0) * 0.01));
      ASSERT_TRUE(pixel && beyond);
      const double error_px = EdgeError_px(image, *pixel, (*beyond - *pixel).normalized());
      EXPECT_LT(std::abs(error_px), 0.2) << edge.transpose();
      sum_px += error_px;
      ++num_edges;
    }
  }
  EXPECT_GE(num_edges, 40);
  EXPECT_LT(std::abs(sum_px / num_edges), 0.05);
}

// A picture that moves by whole pixels shows the same.
TEST(CeilingRender, MovesWithTheCamera) {
  const Camera camera = Small().Pinhole();
  const double pixel_m = (2.6 - 0.35) / camera.fx;
  const Rigid3 pose{Eigen::Quaterniond::Identity(), {4, 0, 0.35}};
  Rigid3 moved = pose;
  moved.translation.x() += 3 * pixel_m;
  const Image<float> a = RenderCeiling(Corridor(), camera, {pose});
  const Image<float> b = RenderCeiling(Corridor(), camera, {moved});
  for (int x = 20; x < 140; ++x) {
    for (int y = 50; y < 70; ++y) {
      EXPECT_NEAR(a.At(x + 3, y), b.At(x, y), 0.5 + 0.002 * a.At(x + 3, y)) << x << " " << y;
    }
  }
}

TEST(CeilingRender, AveragesTimesOfAnExposure) {
  const Camera camera = Small().Pinhole();
  const Rigid3 a{Eigen::Quaterniond::Identity(), {4, 0, 0.35}};
  const Rigid3 b{Eigen::Quaterniond::Identity(), {4.05, 0, 0.35}};
  const Image<float> first = RenderCeiling(Corridor(), camera, {a});
  const Image<float> second = RenderCeiling(Corridor(), camera, {b});
  const Image<float> both = RenderCeiling(Corridor(), camera, {a, b});
  for (int x = 0; x < 160; ++x) {
    EXPECT_NEAR(both.At(x, 60), (first.At(x, 60) + second.At(x, 60)) / 2, 0.1);
  }
  EXPECT_THROW(RenderCeiling(Corridor(), camera, {a, a, a}), UsageError);
}

TEST(CeilingRender, TheBlankStretchShowsNothing) {
  const Rect2& blank = Corridor().plan.blank;
  EXPECT_NEAR(blank.y1 - blank.y0, 8, 1e-9);
  const Rigid3 pose{Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ())),
                    {40, (blank.y0 + blank.y1) / 2, 0.35}};
  const Image<float> image = RenderCeiling(Corridor(), Small().Pinhole(), {pose});
  std::set<float> levels;
  for (int x = 0; x < image.width; ++x) levels.insert(image.At(x, 60));
  EXPECT_EQ(levels.size(), 1U);
  levels.clear();
  for (int x = 0; x < image.width; ++x) levels.insert(image.At(x, 5));
  EXPECT_EQ(levels.size(), 1U);
}

TEST(CeilingRender, LampsSaturateAndDarkenTheRest) {
  SynthesizeCeilingOptions options = Small();
  options.light_change = 0;
  const auto lamp =
      std::ranges::find(Office().plan.fittings, FittingKind::kLamp, &CeilingFitting::kind);
  const Rigid3 pose{Eigen::Quaterniond::Identity(), {lamp->area.x0, 0, 0.35}};
  const double gain = CeilingGains(Office(), {{0, pose}}, options, 1).front();
  EXPECT_GT(gain * kLampBrightness, 255);
  CeilingWorld unlit = Office();
  unlit.plan.fittings.clear();
  unlit = PaintCeilingWorld(unlit.plan, 1, 2);
  EXPECT_LT(gain, 0.9 * CeilingGains(unlit, {{0, pose}}, options, 1).front());
}

TEST(CeilingRender, NoiseHasTheStatedSigma) {
  Image<float> gray{200, 200, 3, std::vector<float>(3 * 200 * 200, 100)};
  const ColorImage picture = ExposeCeiling(gray, {1, 0, 4}, 9);
  double sum = 0;
  for (const std::uint8_t level : picture.pixels) sum += (level - 100.0) * (level - 100.0);
  // Rounding adds 1/12.
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(picture.pixels.size())), 4.01, 0.05);
}

std::map<std::size_t, std::string> Hashes(int num_threads) {
  SynthesizeCeilingOptions options = Small();
  options.layout = "office";
  options.duration_s = 2.5;
  const CeilingRecording recording = PlanCeilingRecording(options, num_threads);
  EXPECT_EQ(recording.building_from_camera.size(), 26U);
  std::map<std::size_t, std::string> hashes;
  std::mutex mutex;
  Progress progress("test", false);
  const auto sink = [&](std::size_t idx, const ColorImage& picture) {
    const std::lock_guard lock(mutex);
    const std::string bytes(picture.pixels.begin(), picture.pixels.end());
    EXPECT_TRUE(hashes.emplace(idx, HashBytes(bytes)).second);
  };
  RunSynthesizeCeiling(options, recording, sink, progress, num_threads);
  std::size_t idx = 1000;
  for (const RecordingFile& file : CeilingListsAndTruth(recording)) {
    hashes.emplace(idx++, file.bytes);
  }
  return hashes;
}

TEST(SynthesizeCeiling, DoesNotDependOnThreads) {
  const auto one = Hashes(1);
  EXPECT_EQ(one.size(), 31U);
  EXPECT_EQ(one, Hashes(4));
}

TEST(SynthesizeCeiling, NoiseSeedLeavesTheBuilding) {
  SynthesizeCeilingOptions options = Small();
  options.layout = "office";
  options.duration_s = 1;
  const CeilingRecording a = PlanCeilingRecording(options, 2);
  options.noise_seed = 7;
  const CeilingRecording b = PlanCeilingRecording(options, 2);
  EXPECT_EQ(TrueCeilingJson(a.world.plan), TrueCeilingJson(b.world.plan));
  EXPECT_NE(a.motion.MountTilt_rad(), b.motion.MountTilt_rad());
  EXPECT_NE(a.wheels.scale_bias, b.wheels.scale_bias);
}

TEST(SynthesizeCeiling, VibrationIsContinuous) {
  const RobotDrive drive = DriveCeilingLegs({{{0, 0}, {20, 0}}}, {});
  UpwardMountOptions mount;
  mount.mount_tilt_rad = 0;
  const UpwardMotion motion(drive, mount, 3);
  double sum = 0;
  int count = 0;
  for (double time_s = 0; time_s < drive.Duration_s(); time_s += 0.0005, ++count) {
    const Rigid3 now = motion.CameraAt(time_s);
    ASSERT_LT(AngleBetween_rad(now, motion.CameraAt(time_s + 0.0005)), 0.0003);
    const double tilt_rad = std::acos(std::min(1.0, (now.rotation * Eigen::Vector3d::UnitZ()).z()));
    sum += tilt_rad * tilt_rad;
  }
  EXPECT_NEAR(std::sqrt(sum / count / 2), 0.002, 0.0003);
}

// So a picture shows what the camera's true pose, at the middle of its exposure, would show.
TEST(SynthesizeCeiling, VibrationIsLinearDuringAnExposure) {
  const RobotDrive drive = DriveCeilingLegs({{{0, 0}, {20, 0}}}, {});
  const UpwardMotion motion(drive, {}, 3);
  for (double time_s = 0.1; time_s < drive.Duration_s(); time_s += 0.1) {
    const Rigid3 now = motion.CameraAt(time_s);
    const Eigen::Vector3d axis = now.rotation * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d before = motion.CameraAt(time_s - 0.005).rotation.matrix().col(2);
    const Eigen::Vector3d after = motion.CameraAt(time_s + 0.005).rotation.matrix().col(2);
    EXPECT_LT((before + after - 2 * axis).norm() / 2, 1e-5);
  }
}

TEST(SynthesizeCeiling, SitesHaveTheCameraThatTheyRecord) {
  for (const std::string site : {"ceiling_corridor", "ceiling_office"}) {
    const SiteConfig config = ReadSiteConfig("configs/sites/" + site + ".toml");
    SynthesizeCeilingOptions of_site;
    const std::string path = "configs/sites/" + site + "/synthesize_ceiling.toml";
    RegisterOptions(of_site).ParseToml(ReadFile(path), path);
    EXPECT_EQ(config.cameras.front().color, of_site.Pinhole());
    EXPECT_EQ(config.cameras.front().robot_from_camera.translation.z(),
              of_site.mount.camera_height_m);
    EXPECT_EQ("ceiling_" + of_site.layout, site);
  }
}

}  // namespace nightmap::synthesize_ceiling_test
