// SPDX-License-Identifier: Apache-2.0
// The batched builder against OctoMap's own insertion, and a tree put together of regions.
#include <gtest/gtest.h>

#include <map>

#include "pipeline/base/random.h"
#include "pipeline/io/trajectory_io.h"
#include "stages/dense/octree/octree.h"
#include "tests/stages/dense/octree/voxel_states.h"
#include "tests/stages/dense/point_cloud/box_room.h"
#include "tests/test_data.h"

namespace nightmap::builders_test {

constexpr bool kFree = false;
constexpr bool kOccupied = true;

// Without what OctoMap has not: margins.
OctreeOptions CommonOptions(double resolution_m) {
  OctreeOptions options;
  options.resolution_m = resolution_m;
  options.depth_filter.pixel_stride = 1;
  options.carve_margin_sigmas = 0;
  return options;
}

OctreeResult Built(const OctreeOptions& options,
                   const KeyframeSource& source,
                   const std::optional<VoxelBox>& region = std::nullopt) {
  Progress progress("octree", false);
  return RunOctree(options, source, nullptr, region, progress, 2);
}

VoxelStates OctomapsStates(OctreeOptions options, const KeyframeSource& source) {
  options.builder = "octomap";
  options.discretize = false;
  return VoxelStates(Built(options, source).tree);
}

void ExpectLikeOctomap(const OctreeOptions& options, const KeyframeSource& source) {
  const VoxelStates reference = OctomapsStates(options, source);
  const VoxelStates ours(Built(options, source).tree);
  EXPECT_GT(reference.Count(kOccupied), 100U);
  EXPECT_GE(ours.IntersectionOverUnion(reference, kOccupied), 0.97) << options.resolution_m;
  EXPECT_GE(ours.IntersectionOverUnion(reference, kFree), 0.95) << options.resolution_m;
}

// A camera of hololens_office, every `stride`-th pose of its device.
KeyframeSource HololensOffice(int stride) {
  RgbdCamera camera;
  camera.color = {540, 360, 495.6, 495.5, 269.5, 169.2, 0, 0, 0, 0, 0};
  camera.min_depth_m = 0.2;
  camera.max_depth_m = 6.0;
  KeyframeSource source;
  source.cameras = {camera};
  const auto poses = ReadTum(TestDataPath("hololens_office/groundtruth.txt"));
  for (std::size_t i = 0; i < poses.size(); i += static_cast<std::size_t>(stride)) {
    Keyframe keyframe;
    keyframe.frame.frame_idx = static_cast<int>(i);
    const std::string name = fmt::format("{:05}.png", poses[i].time_ns / 100'000'000);
    keyframe.frame.color.path = "images/" + name;
    keyframe.frame.depth.path = "depth/" + name;
    keyframe.map_from_camera = poses[i].pose;
    source.keyframes.push_back(keyframe);
  }
  source.load = [camera](const Keyframe& keyframe) {
    return LoadRgbd(keyframe.frame, camera, TestDataPath("hololens_office"));
  };
  return source;
}

// Renders each keyframe only once.
KeyframeSource Cached(KeyframeSource source) {
  std::vector<RgbdImages> images;
  for (const Keyframe& keyframe : source.keyframes) images.push_back(source.load(keyframe));
  source.load = [images](const Keyframe& keyframe) {
    return images[static_cast<std::size_t>(keyframe.frame.frame_idx)];
  };
  return source;
}

// Keyframes whose poses disagree, so that voxels are hit by some and passed by others.
KeyframeSource Shaken(int num_keyframes) {
  Random random(12);
  KeyframeSource source = Cached(LookAround(BoxRoom(), num_keyframes));
  for (Keyframe& keyframe : source.keyframes) {
    keyframe.map_from_camera.translation +=
        Eigen::Vector3d(random.Uniform(-0.1, 0.1), random.Uniform(-0.1, 0.1), 0);
  }
  return source;
}

TEST(Builders, WithoutDiscretizingOursIsOctomaps) {
  const auto source = Cached(LookAround(BoxRoom(), 12));
  for (const double max_range_m : {2.3, 4.0}) {
    OctreeOptions options = CommonOptions(0.1);
    options.max_range_m = max_range_m;
    options.discretize = false;
    const VoxelStates ours(Built(options, source).tree);
    const VoxelStates reference = OctomapsStates(options, source);
    // OctoMap rounds points to float, and so takes a neighbour for one in ten thousand.
    EXPECT_GE(ours.IntersectionOverUnion(reference, kOccupied), 0.999);
    EXPECT_GE(ours.IntersectionOverUnion(reference, kFree), 0.999);
  }
}

TEST(Builders, OursIsLikeOctomapsFrom2To20Centimetres) {
  const auto source = Cached(LookAround(BoxRoom(), 9));
  for (const double resolution_m : {0.02, 0.05, 0.1, 0.2}) {
    ExpectLikeOctomap(CommonOptions(resolution_m), source);
  }
}

TEST(Builders, OursIsLikeOctomapsOnARealRecording) {
  NIGHTMAP_REQUIRE_DATA("hololens_office");
  OctreeOptions options = CommonOptions(0.04);
  options.depth_filter.pixel_stride = 2;
  ExpectLikeOctomap(options, HololensOffice(15));
}

// Both builders, with the defaults and with others, of what is occupied.
std::vector<OctreeOptions> StricterAndMilder(OctreeOptions options) {
  std::vector<OctreeOptions> all;
  for (const std::string builder : {"batched", "octomap"}) {
    options.builder = builder;
    for (const auto& [threshold, min_keyframes] : {std::pair(0.5, 1), {0.8, 2}, {0.3, 3}}) {
      options.occupancy_threshold = threshold;
      options.min_keyframes = min_keyframes;
      all.push_back(options);
    }
  }
  return all;
}

// Cuts `box` in two along its longest edge at a random place, until there are `count` parts.
std::vector<VoxelBox> RandomParts(VoxelBox box, std::size_t count, Random& random) {
  std::vector<VoxelBox> parts{box};
  while (parts.size() < count) {
    VoxelBox first = parts.front();
    parts.erase(parts.begin());
    int axis = 0;
    const int length = (first.max - first.min).maxCoeff(&axis);
    VoxelBox second = first;
    first.max[axis] = second.min[axis] =
        first.min[axis] + length / 4 +
        static_cast<int>(random.Index(static_cast<std::size_t>(length / 2)));
    parts.push_back(first);
    parts.push_back(second);
  }
  return parts;
}

TEST(Builders, RegionsMergedAreTheWholeTree) {
  const TemporaryFolder folder;
  const auto source = Shaken(16);
  Random random(5);
  for (const OctreeOptions& options : StricterAndMilder(CommonOptions(0.15))) {
    const OccupancyTree whole = Built(options, source).tree;
    WriteOctree(folder / "whole.ot", whole);
    WriteBinaryOctree(folder / "whole.bt", whole);
    for (std::size_t count = 2; count <= 8; count += 2) {
      std::vector<std::filesystem::path> parts;
      for (const VoxelBox& part : RandomParts({{-90, -91, -93}, {90, 97, 99}}, count, random)) {
        parts.push_back(folder / fmt::format("part_{}.ot", parts.size()));
        WriteOctree(parts.back(), Built(options, source, part).tree);
      }
      MergeOctrees(parts, folder / "merged.ot", folder / "merged.bt");
      EXPECT_TRUE(ReadBytes(folder / "merged.ot") == ReadBytes(folder / "whole.ot")) << count;
      EXPECT_TRUE(ReadBytes(folder / "merged.bt") == ReadBytes(folder / "whole.bt")) << count;
    }
  }
}

TEST(Builders, AHigherThresholdOccupiesNothingMore) {
  const auto source = Shaken(24);
  for (const std::string builder : {"batched", "octomap"}) {
    OctreeOptions options = CommonOptions(0.1);
    options.builder = builder;
    std::optional<VoxelStates> lower;
    for (const double threshold : {0.2, 0.35, 0.5, 0.71, 0.9, 0.97}) {
      options.occupancy_threshold = threshold;
      const OccupancyTree tree = Built(options, source).tree;
      const VoxelStates states(tree);
      EXPECT_GT(states.Count(kOccupied), 0U) << threshold;
      if (lower) {
        EXPECT_LT(states.Count(kOccupied), lower->Count(kOccupied)) << threshold;
        ForVoxels(tree, [&](std::uint64_t code, bool occupied) {
          EXPECT_TRUE(!occupied || lower->Is(code, kOccupied));
        });
      }
      lower = states;
    }
  }
}

// A keyframe alone occupies what it hits.
TEST(Builders, WhatFewerKeyframesHitIsUnknown) {
  const auto source = Shaken(24);
  for (const std::string builder : {"batched", "octomap"}) {
    OctreeOptions options = CommonOptions(0.1);
    options.builder = builder;
    std::map<std::uint64_t, int> num_hits;
    for (const Keyframe& keyframe : source.keyframes) {
      KeyframeSource one = source;
      one.keyframes = {keyframe};
      ForVoxels(Built(options, one).tree,
                [&](std::uint64_t code, bool occupied) { num_hits[code] += occupied ? 1 : 0; });
    }
    const OccupancyTree all = Built(options, source).tree;
    for (const int min_keyframes : {2, 3}) {
      options.min_keyframes = min_keyframes;
      const VoxelStates states(Built(options, source).tree);
      std::size_t num_left_out = 0;
      ForVoxels(all, [&](std::uint64_t code, bool occupied) {
        const bool left_out = occupied && num_hits[code] < min_keyframes;
        num_left_out += left_out ? 1 : 0;
        EXPECT_EQ(states.Is(code, kOccupied), occupied && !left_out);
        EXPECT_EQ(states.Is(code, kFree), !occupied);
      });
      EXPECT_GT(num_left_out, 100U) << builder;
    }
  }
}

TEST(Builders, ARegionNothingReachesIsEmpty) {
  const auto source = LookAround(BoxRoom(), 2);
  const auto result = Built(CommonOptions(0.1), source, VoxelBox{{500, 500, 500}, {600, 600, 600}});
  EXPECT_TRUE(result.tree.leaves.empty());
  EXPECT_EQ(result.num_rays, 0U);
}

}  // namespace nightmap::builders_test
