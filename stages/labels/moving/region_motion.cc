// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/region_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace nightmap {
namespace {

constexpr double kClearlyStays = -0.5;  // is a score below this
constexpr double kByDepth = 1.0 / 3;
constexpr double kMinVotesPerPixel = 0.02;  // with less nothing is known

std::vector<int> NumPixels(const LabelledRegions& regions) {
  std::vector<int> counts(static_cast<std::size_t>(regions.num) + 1);
  for (const int region : regions.of_pixel.pixels) ++counts[static_cast<std::size_t>(region)];
  return counts;
}

bool SaysNothing(const std::vector<RegionScore>& scores) {
  return std::ranges::none_of(scores, [](const RegionScore& score) { return score.has_value(); });
}

// Whether the region is where it is in the nearest frame before or after.
bool ClearlyStays(const RegionScores& scores) {
  return std::ranges::any_of(std::array{&scores.before, &scores.after}, [](const auto* side) {
    return !side->empty() && side->front().value_or(0) < kClearlyStays;
  });
}

bool Moves(const RegionScores& scores) {
  if (SaysNothing(scores.before) && SaysNothing(scores.after)) return true;
  if (ClearlyStays(scores)) return false;
  for (std::size_t i = 0; i < std::max(scores.before.size(), scores.after.size()); ++i) {
    const RegionScore before = i < scores.before.size() ? scores.before[i] : std::nullopt;
    const RegionScore after = i < scores.after.size() ? scores.after[i] : std::nullopt;
    if ((before || after) && before.value_or(1) > 0 && after.value_or(1) > 0) return true;
  }
  return false;
}

}  // namespace

void AddScores(double stays_weight,
               const Evidence& by_depth,
               const Evidence& by_flow,
               bool forward,
               int num_offsets,
               FrameRegions* frame) {
  const std::vector<int> num_pixels = NumPixels(frame->regions);
  std::vector<double> gone(num_pixels.size()), stays(num_pixels.size());
  for (std::size_t i = 0; i < frame->regions.of_pixel.pixels.size(); ++i) {
    const auto region = static_cast<std::size_t>(frame->regions.of_pixel.pixels[i]);
    gone[region] += by_depth.gone.pixels[i] + by_flow.gone.pixels[i];
    stays[region] += stays_weight * (kByDepth * by_depth.stays.pixels[i] + by_flow.stays.pixels[i]);
  }
  for (std::size_t region = 1; region < num_pixels.size(); ++region) {
    const double votes = gone[region] + stays[region];
    RegionScores& scores = frame->scores[region - 1];
    const bool is_known = votes > kMinVotesPerPixel * num_pixels[region];
    auto& side = forward ? scores.after : scores.before;
    side.insert(side.end(),
                static_cast<std::size_t>(num_offsets),
                is_known ? RegionScore((gone[region] - stays[region]) / votes) : std::nullopt);
  }
}

std::vector<int> SameRegions(const SmallCamera& camera,
                             const SmallFrame& frame,
                             const FrameRegions& regions,
                             const FrameRegions& next,
                             const Rigid3& next_from_frame) {
  std::map<std::pair<int, int>, int> num_common;
  for (int y = 0; y < frame.depth.height; ++y) {
    for (int x = 0; x < frame.depth.width; ++x) {
      const int region = regions.regions.of_pixel.At(x, y);
      if (region == 0 || frame.depth.At(x, y) <= 0) continue;
      const auto i = static_cast<std::size_t>(y * frame.depth.width + x);
      const auto seen =
          camera.depth.Project(next_from_frame * (camera.depth_rays[i] * frame.depth.At(x, y)));
      if (!seen || !camera.depth.Contains(*seen)) continue;
      const int there = next.regions.of_pixel.At(static_cast<int>(std::lround(seen->x())),
                                                 static_cast<int>(std::lround(seen->y())));
      if (there > 0) ++num_common[{region, there}];
    }
  }
  const std::vector<int> sizes = NumPixels(regions.regions);
  const std::vector<int> next_sizes = NumPixels(next.regions);
  std::vector<int> same(static_cast<std::size_t>(regions.regions.num));
  std::vector<int> most(same.size());
  for (const auto& [pair, count] : num_common) {
    const auto [region, there] = pair;
    const int larger = std::max(sizes[static_cast<std::size_t>(region)],
                                next_sizes[static_cast<std::size_t>(there)]);
    const auto i = static_cast<std::size_t>(region - 1);
    if (2 * count < larger || count <= most[i]) continue;
    most[i] = count;
    same[i] = there;
  }
  return same;
}

std::vector<std::vector<bool>> DecideRegions(const std::vector<const FrameRegions*>& frames,
                                             const std::vector<std::vector<int>>& same) {
  std::vector<std::vector<bool>> moves;
  for (const FrameRegions* frame : frames) {
    moves.emplace_back();
    for (const RegionScores& scores : frame->scores) moves.back().push_back(Moves(scores));
  }
  const auto follow = [&](std::size_t from, std::size_t region, std::size_t to, std::size_t there) {
    if (moves[from][region] && !ClearlyStays(frames[to]->scores[there])) {
      moves[to][there] = true;
    }
  };
  const auto for_pairs = [&](std::size_t k, const auto& use) {
    for (std::size_t region = 0; region < same[k].size(); ++region) {
      if (same[k][region] > 0) use(region, static_cast<std::size_t>(same[k][region] - 1));
    }
  };
  for (std::size_t k = 0; k < same.size(); ++k) {
    for_pairs(k, [&](std::size_t region, std::size_t there) { follow(k, region, k + 1, there); });
  }
  for (std::size_t k = same.size(); k-- > 0;) {
    for_pairs(k, [&](std::size_t region, std::size_t there) { follow(k + 1, there, k, region); });
  }
  return moves;
}

}  // namespace nightmap
