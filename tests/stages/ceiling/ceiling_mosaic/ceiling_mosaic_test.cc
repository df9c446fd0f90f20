// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_mosaic/ceiling_mosaic.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/input_error.h"
#include "pipeline/base/random.h"
#include "stages/ceiling/ceiling_mosaic/ceiling_heights.h"
#include "stages/ceiling/ceiling_mosaic/choose_views.h"
#include "stages/ceiling/ceiling_mosaic/counted_median.h"
#include "stages/ceiling/ceiling_mosaic/mosaic_files.h"
#include "tests/test_data.h"

namespace nightmap::ceiling_mosaic_test {

constexpr double kHeight_m = 2.6;

// A ceiling without repetition: brightness of a place.
double Painted(double x, double y) {
  return 128 + 60 * std::sin(3 * x + std::sin(2 * y)) + 40 * std::sin(4 * y + x);
}

Camera SmallCamera() {
  Camera camera;
  camera.width = 160;
  camera.height = 120;
  camera.fx = camera.fy = 80;
  camera.cx = 79.5;
  camera.cy = 59.5;
  camera.k1 = -0.02;
  return camera;
}

// A camera's picture of a level ceiling.
ColorImage Photograph(const Camera& camera, const Rigid3& map_from_camera, double height_m) {
  ColorImage image{camera.width, camera.height, 3, {}};
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector3d ray =
          map_from_camera.rotation *
          camera.BackProject({static_cast<double>(x), static_cast<double>(y)}, 1);
      const double scale = (height_m - map_from_camera.translation.z()) / ray.z();
      const Eigen::Vector3d point = map_from_camera.translation + scale * ray;
      const auto value = static_cast<std::uint8_t>(std::lround(Painted(point.x(), point.y())));
      image.pixels.insert(image.pixels.end(), {value, value, value});
    }
  }
  return image;
}

// A drive of 2 m with a turn, under a camera that is mounted with a tilt.
CeilingMosaicInput MakeInput() {
  CeilingMosaicInput input;
  input.camera = SmallCamera();
  const Rigid3 robot_from_camera{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitX())), {0.1, 0, 0.4}};
  for (std::size_t i = 0; i < 8; ++i) {
    const double way = 0.25 * static_cast<double>(i);
    const Rigid3 robot{Eigen::Quaterniond(Eigen::AngleAxisd(way, Eigen::Vector3d::UnitZ())),
                       {way, 0.1 * way, 0}};
    input.views.push_back({robot * robot_from_camera, i});
    for (double side = -1; side <= 1; side += 0.5)
      input.landmarks.emplace_back(way, side, kHeight_m);
  }
  const auto views = input.views;
  input.load = [views](std::size_t frame) {
    return Photograph(SmallCamera(), views[frame].map_from_camera, kHeight_m);
  };
  return input;
}

CeilingMosaic Make(const CeilingMosaicInput& input,
                   const CeilingMosaicOptions& options = {},
                   int num_threads = 2) {
  Progress progress("ceiling_mosaic", false);
  return RunCeilingMosaic(options, input, progress, num_threads);
}

// Mean difference of the picture from the paint, where it was seen.
double Difference(const CeilingMosaic& mosaic) {
  double sum = 0;
  int count = 0;
  for (int y = 0; y < mosaic.picture.height; ++y) {
    for (int x = 0; x < mosaic.picture.width; ++x) {
      const int value = mosaic.picture.At(x, y);
      if (value == 0) continue;
      const Eigen::Vector2d place =
          mosaic.origin +
          mosaic.resolution_m * Eigen::Vector2d(x + 0.5, mosaic.picture.height - y - 0.5);
      sum += std::abs(value - Painted(place.x(), place.y()));
      ++count;
    }
  }
  EXPECT_GT(count, 10'000);
  return sum / count;
}

TEST(CeilingMosaic, ShowsTheCeilingWhereItIs) {
  const CeilingMosaic mosaic = Make(MakeInput());
  EXPECT_LT(Difference(mosaic), 1.5);
  EXPECT_LT(mosaic.median_deviation, 2);
  EXPECT_GT(mosaic.covered_m2, 10);
  EXPECT_TRUE(mosaic.skipped.empty());
}

TEST(CeilingMosaic, AWrongHeightShows) {
  CeilingMosaicInput input = MakeInput();
  for (auto& landmark : input.landmarks) landmark.z() += 0.3;
  const CeilingMosaic mosaic = Make(input);
  EXPECT_GT(Difference(mosaic), 5);
  EXPECT_GT(mosaic.median_deviation, 3 * Make(MakeInput()).median_deviation);
}

TEST(CeilingMosaic, IsTheSameAtAnyNumberOfThreads) {
  CeilingMosaicOptions options;
  options.resolution_m = 0.005;  // several blocks
  const CeilingMosaic one = Make(MakeInput(), options, 1), four = Make(MakeInput(), options, 4);
  EXPECT_GT(one.picture.width, 512);
  EXPECT_EQ(one.picture.pixels, four.picture.pixels);
  EXPECT_EQ(one.median_deviation, four.median_deviation);
}

TEST(CeilingMosaic, APictureThatCannotBeReadIsSkippedOnce) {
  CeilingMosaicInput input = MakeInput();
  const auto load = input.load;
  input.load = [load](std::size_t frame) {
    if (frame == 3) throw DataError("up/3.jpg: truncated");
    return load(frame);
  };
  const CeilingMosaic mosaic = Make(input, {0.005, 30000, 0.2});
  ASSERT_EQ(mosaic.skipped.size(), 1U);
  EXPECT_THAT(mosaic.skipped[0], testing::HasSubstr("up/3.jpg"));
  EXPECT_LT(Difference(mosaic), 1.5);
}

TEST(CeilingMosaic, PixelsOfAWideCeilingAreLarger) {
  CeilingMosaicOptions options;
  options.max_edge_px = 150;
  const CeilingMosaic coarse = Make(MakeInput(), options), fine = Make(MakeInput());
  EXPECT_EQ(std::max(coarse.picture.width, coarse.picture.height), 150);
  EXPECT_GT(coarse.resolution_m, fine.resolution_m);
  EXPECT_NEAR(coarse.covered_m2 / fine.covered_m2, 1, 0.03);
  EXPECT_LT((coarse.origin - fine.origin).cwiseAbs().maxCoeff(), coarse.resolution_m);
  options.resolution_m = 10 * coarse.resolution_m;
  EXPECT_EQ(Make(MakeInput(), options).resolution_m, options.resolution_m);
}

TEST(CeilingMosaic, SaysWhatItCannotDo) {
  CeilingMosaicInput input = MakeInput();
  for (auto& landmark : input.landmarks) landmark.z() = 0.2;
  EXPECT_THROW(Make(input), InputError);
  input.landmarks.clear();
  EXPECT_THROW(Make(input), InputError);
}

TEST(CeilingMosaic, WorldFileAndYamlTellThePlace) {
  CeilingMosaic mosaic;
  mosaic.resolution_m = 0.5;
  mosaic.origin = {-1, 2};
  mosaic.picture = {4, 6, 3, {}};
  EXPECT_EQ(MosaicToWorldFile(mosaic),
            "0.500000000\n0\n0\n-0.500000000\n-0.750000000\n4.750000000\n");
  EXPECT_EQ(
      MosaicToYaml(mosaic, "mosaic.png"),
      "image: mosaic.png\nresolution: 0.500000000\norigin: [-1.000000000, 2.000000000, 0.0]\n");
}

TEST(CountedMedian, IsThatOfTheListOfAllValues) {
  Random random(3, 0, 0);
  EXPECT_EQ(CountedMedian().Get(), 0);
  for (const std::size_t num : {1U, 2U, 7U, 1001U}) {
    CountedMedian first, second;
    std::vector<double> all;
    for (std::size_t i = 0; i < num; ++i) {
      all.push_back(std::abs(20 * random.Gaussian()));
      (i % 3 == 0 ? first : second).Add(all.back());
    }
    first.Add(second);
    std::ranges::sort(all);
    EXPECT_NEAR(first.Get(), all[num / 2], 0.0051) << num;
  }
}

TEST(CeilingHeights, AreTheMedianOfTheLandmarksAround) {
  std::vector<Eigen::Vector3d> points;
  for (double x = 0; x < 4; x += 0.2) {
    for (double y = 0; y < 2; y += 0.2) points.emplace_back(x, y, x < 2 ? 2.6 : 3.0);
  }
  points.emplace_back(0.5, 0.5, 1.0);  // a lamp that hangs down
  const CeilingHeights heights(points, 0.5, {0, 0}, {6, 2});
  EXPECT_EQ(heights.At_m({0.5, 0.5}), 2.6);
  EXPECT_EQ(heights.At_m({3.5, 1}), 3.0);
  EXPECT_EQ(heights.At_m({5.9, 1}), heights.At_m({50, 1}));  // nothing is there: that of most
}

TEST(CeilingMosaic, ViewsAreApart) {
  std::vector<FrameRecord> frames(10);
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].time_ns = static_cast<std::int64_t>(i);
    Rigid3 pose;
    pose.translation.x() = 0.1 * static_cast<double>(i);
    if (i != 0) poses.push_back({frames[i].time_ns, pose});
  }
  const auto views = ChooseViews(frames, poses, Rigid3{});
  ASSERT_EQ(views.size(), 3U);
  EXPECT_EQ(views[0].frame, 1U);  // the first one with a pose
  EXPECT_EQ(views[1].frame, 4U);
}

}  // namespace nightmap::ceiling_mosaic_test
