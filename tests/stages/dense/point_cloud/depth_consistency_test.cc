// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/depth_consistency.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "stages/dense/point_cloud/fuse_depth.h"
#include "tests/stages/dense/point_cloud/box_room.h"

namespace nightmap::depth_consistency_test {

constexpr double kWall_m = 2.0;

PointCloudOptions AskFor(int min_frames) {
  PointCloudOptions options;
  options.depth_filter.pixel_stride = 1;
  options.voxel_size_m = 0.04;
  options.surface_radius_m = 0.15;
  options.min_consistent_frames = min_frames;
  return options;
}

RgbdCamera WallCamera() {
  RgbdCamera camera;
  camera.color = {160, 120, 130, 130, 79.5, 59.5, 0, 0, 0, 0, 0};
  return camera;
}

// A wall that fills the picture.
DepthImage Wall() {
  DepthImage depth{160, 120, 1, {}};
  depth.pixels.assign(160 * 120, static_cast<float>(kWall_m));
  return depth;
}

Testimony Ask(const DepthImage& depth, const Eigen::Vector3d& point) {
  const RgbdCamera camera = WallCamera();
  return DepthView(camera, Rigid3(), depth).Of(AskFor(1), point);
}

TEST(DepthView, ConfirmsWithinTheToleranceAndSeesThroughBeyond) {
  const double tolerance_m = DepthTolerance_m(AskFor(1), DepthNoise().Sigma_m(kWall_m));
  EXPECT_EQ(Ask(Wall(), {0.1, 0.2, kWall_m}), Testimony::kConfirms);
  EXPECT_EQ(Ask(Wall(), {0.1, 0.2, kWall_m - 0.9 * tolerance_m}), Testimony::kConfirms);
  EXPECT_EQ(Ask(Wall(), {0.1, 0.2, kWall_m + 0.9 * tolerance_m}), Testimony::kConfirms);
  EXPECT_EQ(Ask(Wall(), {0.1, 0.2, kWall_m - 1.1 * tolerance_m}), Testimony::kSeesThrough);
  EXPECT_EQ(Ask(Wall(), {0.1, 0.2, kWall_m + 1.3 * tolerance_m}), Testimony::kNone);  // hidden
}

TEST(DepthView, SaysNothingOfWhatItCannotSee) {
  EXPECT_EQ(Ask(Wall(), {0, 0, -1}), Testimony::kNone);
  EXPECT_EQ(Ask(Wall(), {3, 0, 1}), Testimony::kNone);
  DepthImage holes = Wall();
  std::ranges::fill(holes.pixels, 0.0F);
  EXPECT_EQ(Ask(holes, {0, 0, 1}), Testimony::kNone);
  DepthImage far = Wall();
  std::ranges::fill(far.pixels, 9.0F);  // deeper than max_depth_m, but measured
  EXPECT_EQ(Ask(far, {0, 0, 1}), Testimony::kSeesThrough);
  EXPECT_EQ(Ask(far, {0, 0, 9}), Testimony::kNone);
}

TEST(DepthView, DoesNotSeeThroughTheEdgeOfSomethingNearer) {
  DepthImage edge = Wall();
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 80; ++x) edge.At(x, y) = 1.0F;
  }
  const Camera camera = WallCamera().color;
  const auto ask = [&](double x, double depth_m) {
    return Ask(edge, camera.BackProject({x, 60}, depth_m));
  };
  EXPECT_EQ(ask(79, 1.0), Testimony::kConfirms);
  EXPECT_EQ(ask(80, 1.0), Testimony::kConfirms);  // beside it
  EXPECT_EQ(ask(80, 1.5), Testimony::kNone);      // half hidden
  EXPECT_EQ(ask(82, 1.5), Testimony::kSeesThrough);
}

TEST(DepthView, ReachesEveryBallOfWhichItSaysSomething) {
  const BoxRoom room;
  const KeyframeSource source = LookAround(room, 4);
  const PointCloudOptions options = AskFor(1);
  int num_reached = 0;
  for (const Keyframe& keyframe : source.keyframes) {
    const DepthView view(source.cameras[0], keyframe.map_from_camera, source.load_depth(keyframe));
    for (int i = 0; i < 5000; ++i) {
      Random random(2, static_cast<std::uint64_t>(i));
      const auto draw = [&](double size) { return random.Uniform(-size, size); };
      const Eigen::Vector3d point(draw(3), draw(3), draw(2));
      const Eigen::Vector3d off = 0.2 * Eigen::Vector3d(draw(1), draw(1), draw(1));
      const bool reaches = view.Reaches(point + off, off.norm(), options.max_depth_m);
      EXPECT_TRUE(reaches || view.Of(options, point) == Testimony::kNone) << point.transpose();
      num_reached += reaches ? 1 : 0;
    }
  }
  EXPECT_LT(num_reached, 4 * 5000 / 2);  // most is to the sides and behind
}

// A room, of which one keyframe measures a patch that floats in it.
class FloatingPatch : public testing::Test {
 protected:
  static constexpr int kLiar = 3;

  KeyframeSource Source() const {
    KeyframeSource source = LookAround(BoxRoom(), 36);
    const auto lie = [](const Keyframe& keyframe, DepthImage depth) {
      if (keyframe.keyframe_idx != kLiar) return depth;
      for (int y = 40; y < 80; ++y) {
        for (int x = 60; x < 100; ++x) depth.At(x, y) = 0.9F;
      }
      return depth;
    };
    source.load = [lie, load = source.load](const Keyframe& keyframe) {
      RgbdImages images = load(keyframe);
      images.depth = lie(keyframe, std::move(images.depth));
      return images;
    };
    source.load_depth = [load = source.load](const Keyframe& keyframe) {
      return load(keyframe).depth;
    };
    return source;
  }

  static PointCloudResult Make(const PointCloudOptions& options,
                               const KeyframeSource& source,
                               int num_threads = 2) {
    Progress progress("point_cloud", false);
    return RunPointCloud(options, source, progress, num_threads);
  }

  static std::size_t NumFloating(const PointCloudResult& result) {
    return static_cast<std::size_t>(
        std::ranges::count_if(result.points, [](const CloudPoint& point) {
          return BoxRoom().DistanceToWall_m(point.position_in_map.cast<double>()) > 0.15;
        }));
  }
};

TEST_F(FloatingPatch, StaysWithoutTheTestAndGoesWithIt) {
  const PointCloudResult off = Make(AskFor(0), Source());
  const PointCloudResult on = Make(AskFor(1), Source());
  const std::size_t num_floating = NumFloating(off);
  EXPECT_GT(num_floating, 30U);
  EXPECT_EQ(off.num_inconsistent, 0U);
  EXPECT_EQ(NumFloating(on), 0U);
  EXPECT_GE(on.num_inconsistent, num_floating);
  // The walls lose nothing.
  EXPECT_GT(on.points.size(), (off.points.size() - num_floating) * 995 / 1000);
}

TEST_F(FloatingPatch, BlocksHeldOutRaysUntilItGoes) {
  const RayAgreement off = Make(AskFor(0), Source()).held_out;
  const RayAgreement on = Make(AskFor(1), Source()).held_out;
  EXPECT_EQ(off.num_rays, on.num_rays);
  EXPECT_GT(off.num_blocked, 0U);
  EXPECT_EQ(on.num_blocked, 0U);
  EXPECT_GT(on.num_agreeing, off.num_agreeing);
}

TEST_F(FloatingPatch, GoesInTilesAsInTheWhole) {
  const PointCloudOptions options = AskFor(2);
  KeyframeSource source = Source();
  const PointCloudResult whole = Make(options, source);
  std::size_t num_points = 0, num_inconsistent = 0, num_rays = 0;
  for (const double x : {-3.013, 0.013}) {
    source.region = {{{x, -3.0}, {x + 3.026, 3.0}}, 0.51, options.max_depth_m};
    const PointCloudResult tile = Make(options, source);
    num_points += tile.points.size();
    num_inconsistent += tile.num_inconsistent;
    num_rays += tile.held_out.num_rays;
  }
  EXPECT_GT(num_inconsistent, 0U);
  EXPECT_EQ(num_points, whole.points.size());
  EXPECT_EQ(num_inconsistent, whole.num_inconsistent);
  EXPECT_EQ(num_rays, whole.held_out.num_rays);
}

TEST_F(FloatingPatch, SameAtAnyNumberOfThreadsAndMoreFramesAskedForKeepFewerPoints) {
  std::size_t before = Make(AskFor(0), Source()).points.size();
  for (const int min_frames : {1, 3, 6}) {
    const PointCloudResult one = Make(AskFor(min_frames), Source(), 1);
    const PointCloudResult many = Make(AskFor(min_frames), Source(), 5);
    ASSERT_EQ(one.points.size(), many.points.size());
    for (std::size_t i = 0; i < one.points.size(); ++i) {
      ASSERT_EQ(one.points[i].position_in_map, many.points[i].position_in_map);
    }
    EXPECT_EQ(one.num_inconsistent, many.num_inconsistent);
    EXPECT_EQ(one.held_out.num_agreeing, many.held_out.num_agreeing);
    EXPECT_LT(one.points.size(), before);
    before = one.points.size();
  }
}

TEST_F(FloatingPatch, UnreadableDepthSaysNothing) {
  KeyframeSource source = Source();
  const std::size_t num_points = Make(AskFor(1), source).points.size();
  source.load_depth = [](const Keyframe& keyframe) -> DepthImage {
    throw DataError("frame {}: truncated", keyframe.keyframe_idx);
  };
  EXPECT_TRUE(Make(AskFor(1), source).points.empty());  // nobody confirms anything
  KeyframeSource few = Source();
  few.load_depth = [load = few.load](const Keyframe& keyframe) {
    if (keyframe.keyframe_idx == 20) throw DataError("frame 20: truncated");
    return load(keyframe).depth;
  };
  EXPECT_NEAR(static_cast<double>(Make(AskFor(1), few).points.size()),
              static_cast<double>(num_points),
              0.01 * static_cast<double>(num_points));
}

}  // namespace nightmap::depth_consistency_test
