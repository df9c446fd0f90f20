// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/octree/trace_rays.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "pipeline/base/random.h"
#include "stages/dense/octree/voxel_walk.h"

namespace nightmap::trace_rays_test {

constexpr double kResolution_m = 0.1;

TraceOptions NoLimits() { return {kResolution_m, 1000.0, false, std::nullopt}; }

// The evidence of a rays, voxel by voxel.
struct Listed {
  std::map<std::uint64_t, std::array<std::uint32_t, 4>> hits;  // sums of color, count
  std::set<std::uint64_t> passed;

  void Add(const KeyframeEvidence& evidence) {
    for (const auto& [block, seen] : evidence.blocks) {
      const std::uint64_t first = block << kBlockShift;
      const ColorSum* color = evidence.colors.data() + seen.first_color;
      seen.hit.ForEach([&](std::size_t i) {
        hits[first | i] = {color->rgb[0], color->rgb[1], color->rgb[2], color->count};
        ++color;
      });
      seen.passed.ForEach([&](std::size_t i) { passed.insert(first | i); });
    }
  }
  bool operator==(const Listed&) const = default;
};

Listed ListRays(const KeyframeRays& rays, const TraceOptions& options) {
  Listed listed;
  listed.Add(TraceRays(rays, options));
  return listed;
}

KeyframeRays RandomRays(std::uint64_t seed, int num_points) {
  Random random(seed);
  const auto place = [&](double range_m) {
    Eigen::Vector3d point;
    for (int i = 0; i < 3; ++i) point[i] = random.Uniform(-range_m, range_m);
    return point;
  };
  KeyframeRays rays;
  rays.origin_in_map = place(0.5);
  for (int i = 0; i < num_points; ++i) {
    const auto channel = [&] { return static_cast<std::uint8_t>(random.Index(256)); };
    rays.points.push_back({place(2.0), 0, {channel(), channel(), channel()}});
  }
  return rays;
}

std::uint64_t CodeAt(const Eigen::Vector3d& point) {
  return MortonCode(VoxelOf(point, kResolution_m));
}

// Share of the segment that lies in a voxel.
double ShareInVoxel(const VoxelKey& voxel, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  double begin = 0;
  double end = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double step = to[axis] - from[axis];
    const double one = (voxel[axis] * kResolution_m - from[axis]) / step;
    const double other = ((voxel[axis] + 1) * kResolution_m - from[axis]) / step;
    begin = std::max(begin, std::min(one, other));
    end = std::min(end, std::max(one, other));
  }
  return end - begin;
}

TEST(TraceRays, PassesTheVoxelsThatTheRayGoesThrough) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const KeyframeRays rays = RandomRays(seed, 1);
    const Eigen::Vector3d& end = rays.points[0].point_in_map;
    const Listed listed = ListRays(rays, NoLimits());
    EXPECT_EQ(listed.hits.size(), 1U);
    EXPECT_EQ(listed.hits.count(CodeAt(end)), 1U);
    std::size_t num_passed = 0;
    const VoxelKey low = VoxelOf(end.cwiseMin(rays.origin_in_map), kResolution_m);
    const VoxelKey high = VoxelOf(end.cwiseMax(rays.origin_in_map), kResolution_m);
    for (int x = low.x(); x <= high.x(); ++x) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int z = low.z(); z <= high.z(); ++z) {
          const double share = ShareInVoxel({x, y, z}, rays.origin_in_map, end);
          const std::uint64_t code = MortonCode({x, y, z});
          const bool passed = listed.passed.count(code) > 0;
          num_passed += passed ? 1 : 0;
          if (std::abs(share) < 1e-9) continue;  // touches an edge
          EXPECT_EQ(passed, share > 0 && code != CodeAt(end)) << seed;
        }
      }
    }
    EXPECT_EQ(num_passed, listed.passed.size()) << seed;
  }
}

TEST(TraceRays, ARayAlongAnAxisPassesARow) {
  KeyframeRays rays;
  rays.origin_in_map = {0.05, 0.05, 0.05};
  for (const double x : {1.05, -0.95}) {
    rays.points = {{{x, 0.05, 0.05}, 0, {}}};
    EXPECT_EQ(ListRays(rays, NoLimits()).passed.size(), 10U);
  }
  rays.points = {{rays.origin_in_map, 0, {}}};
  EXPECT_TRUE(ListRays(rays, NoLimits()).passed.empty());
}

TEST(TraceRays, TwoWalksAtATimeVisitWhatEachDoesAlone) {
  Random random(3);
  for (int num_walks = 0; num_walks < 40; ++num_walks) {
    std::multiset<std::uint64_t> expected;
    std::multiset<std::uint64_t> visited;
    const auto visit = [&](int lane, std::uint64_t voxel) {
      EXPECT_TRUE(lane == 0 || lane == 1);
      visited.insert(voxel);
    };
    VoxelWalkPair pair;
    for (int i = 0; i < num_walks; ++i) {
      Eigen::Vector3d start;
      Eigen::Vector3d ray;
      for (int axis = 0; axis < 3; ++axis) {
        start[axis] = random.Uniform(-20, 20);
        ray[axis] = random.Index(4) == 0 ? 0 : random.Uniform(-20, 20);
      }
      const VoxelWalk walk(start, ray);
      const int count = (VoxelOf(start + ray, 1) - VoxelOf(start, 1)).cwiseAbs().sum();
      walk.Visit(count, [&](std::uint64_t voxel) { expected.insert(voxel); });
      pair.Add(walk, count, visit);
    }
    pair.Finish(visit);
    EXPECT_EQ(visited, expected);
  }
}

TEST(TraceRays, HitBeatsPassedAndColorsAreSummedPerVoxel) {
  const KeyframeRays rays = RandomRays(7, 2000);
  Listed expected;
  for (const RayEnd& point : rays.points) {
    auto& sum = expected.hits[CodeAt(point.point_in_map)];
    for (std::size_t i = 0; i < 3; ++i) sum[i] += point.rgb[i];
    ++sum[3];
  }
  for (const RayEnd& point : rays.points) {
    for (const std::uint64_t voxel : ListRays({rays.origin_in_map, {point}}, NoLimits()).passed) {
      if (expected.hits.count(voxel) == 0) expected.passed.insert(voxel);
    }
  }
  EXPECT_TRUE(ListRays(rays, NoLimits()) == expected);
}

TEST(TraceRays, DiscretizedRaysStartAtTheMeanOfTheirVoxel) {
  KeyframeRays rays;
  rays.points = {{{1.02, 0.51, 0.33}, 0, {10, 20, 30}}, {{1.08, 0.57, 0.37}, 0, {30, 20, 10}}};
  TraceOptions options = NoLimits();
  options.discretize = true;
  const KeyframeEvidence evidence = TraceRays(rays, options);
  EXPECT_EQ(evidence.num_rays, 1U);
  Listed both;
  both.Add(evidence);
  const Listed mean = ListRays({{0, 0, 0}, {{{1.05, 0.54, 0.35}, 0, {}}}}, NoLimits());
  EXPECT_EQ(both.passed, mean.passed);
  EXPECT_EQ(both.hits.begin()->second, (std::array<std::uint32_t, 4>{40, 40, 40, 2}));
}

TEST(TraceRays, NothingIsPassedWithinTheMargin) {
  KeyframeRays rays;
  rays.origin_in_map = {0.05, 0.05, 0.05};
  rays.points = {{{1.05, 0.05, 0.05}, 0.35, {}}};
  const Listed listed = ListRays(rays, NoLimits());
  EXPECT_EQ(listed.passed.size(), 7U);
  EXPECT_EQ(listed.passed.count(CodeAt({0.65, 0.05, 0.05})), 1U);
  EXPECT_EQ(listed.passed.count(CodeAt({0.75, 0.05, 0.05})), 0U);
  rays.points[0].margin_m = 2;
  EXPECT_TRUE(ListRays(rays, NoLimits()).passed.empty());
}

TEST(TraceRays, PointsBeyondTheRangeOnlyFree) {
  KeyframeRays rays;
  rays.origin_in_map = {0.05, 0.05, 0.05};
  rays.points = {{{3.05, 0.05, 0.05}, 0, {}}, {{3.05, 0.06, 0.05}, 0, {}}};
  TraceOptions options = NoLimits();
  options.max_range_m = 1.03;
  for (const bool discretize : {false, true}) {
    options.discretize = discretize;
    const KeyframeEvidence evidence = TraceRays(rays, options);
    Listed listed;
    listed.Add(evidence);
    EXPECT_TRUE(listed.hits.empty());
    EXPECT_EQ(listed.passed.size(), 10U);
    EXPECT_EQ(evidence.num_rays, discretize ? 1U : 2U);
  }
}

TEST(TraceRays, RegionsThatShareNothingSplitTheEvidence) {
  for (const bool discretize : {false, true}) {
    const KeyframeRays rays = RandomRays(11, 500);
    TraceOptions options = NoLimits();
    options.discretize = discretize;
    options.max_range_m = 1.7;
    const Listed whole = ListRays(rays, options);
    Listed joined;
    std::size_t num_voxels = 0;
    for (const auto& [low, high] : {std::pair{-100, -3}, {-3, 0}, {0, 8}, {8, 9}, {9, 100}}) {
      options.region = VoxelBox{{low, -100, -100}, {high, 100, 100}};
      const KeyframeEvidence part = TraceRays(rays, options);
      joined.Add(part);
      for (const auto& entry : part.blocks) {
        num_voxels += entry.value.hit.Count() + entry.value.passed.Count();
      }
    }
    EXPECT_TRUE(joined == whole);
    EXPECT_EQ(num_voxels, whole.hits.size() + whole.passed.size());
  }
}

}  // namespace nightmap::trace_rays_test
