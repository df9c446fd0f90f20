// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/ghosts/ghosts.h"

#include <algorithm>
#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"
#include "stages/labels/ghosts/keyframe_view.h"

namespace nightmap {
namespace {

// Another keyframe sees through a thing when what it sees is so much farther, for errors of the
// poses.
constexpr double kMinDifference_m = 0.1;
constexpr double kNumSigmas = 2;  // and by so many standard deviations of both depths more
// Smaller ones are edges of masks.
constexpr std::size_t kMinBlocks = 10;

bool IsGhost(const GhostsOptions& options,
             const std::vector<std::optional<KeyframeView>>& views,
             std::size_t own,
             const RegionPoints& points) {
  if (points.size() < kMinBlocks) return false;
  Eigen::Vector3d centre_in_map = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) {
    centre_in_map += point / static_cast<double>(points.size());
  }
  double radius_m = 0;
  for (const Eigen::Vector3d& point : points) {
    radius_m = std::max(radius_m, (point - centre_in_map).norm());
  }
  int num_through = 0;
  for (std::size_t i = 0; i < views.size() && num_through < options.min_keyframes; ++i) {
    if (i == own || !views[i] || !MaySee(*views[i], centre_in_map, radius_m)) continue;
    num_through += SeesThrough(*views[i], points, options.min_share, kMinDifference_m, kNumSigmas);
  }
  return num_through >= options.min_keyframes;
}

// Whether each region of a view is a ghost.
std::vector<bool> FindGhosts(const GhostsOptions& options,
                             const std::vector<std::optional<KeyframeView>>& views,
                             std::size_t k) {
  std::vector<bool> are_ghosts;
  for (const RegionPoints& points : views[k]->points) {
    are_ghosts.push_back(IsGhost(options, views, k, points));
  }
  return are_ghosts;
}

// Whether a block, or one beside it, shows a ghost: edges of labels lie within blocks.
bool IsGhostAround(const KeyframeView& view, const std::vector<bool>& are_ghosts, int x, int y) {
  for (int by = std::max(y - 1, 0); by <= std::min(y + 1, view.region.height - 1); ++by) {
    for (int bx = std::max(x - 1, 0); bx <= std::min(x + 1, view.region.width - 1); ++bx) {
      const int region = view.region.At(bx, by);
      if (region > 0 && are_ghosts[static_cast<std::size_t>(region - 1)]) return true;
    }
  }
  return false;
}

// Adds to a mask what may move in and beside the blocks of ghosts.
void AddGhosts(const KeyframeView& view,
               const std::vector<bool>& are_ghosts,
               const GrayImage& may_move,
               GrayImage* mask) {
  for (int y = 0; y < may_move.height; ++y) {
    for (int x = 0; x < may_move.width; ++x) {
      if (may_move.At(x, y) == 0) continue;
      if (IsGhostAround(view, are_ghosts, x / view.block_px, y / view.block_px)) {
        mask->At(x, y) = 255;
      }
    }
  }
}

}  // namespace

GhostsResult RunGhosts(const GhostsOptions& options,
                       const GhostsInput& input,
                       Progress& progress,
                       int num_threads) {
  const std::size_t count = input.keyframes.size();
  std::vector<std::optional<KeyframeView>> views(count);
  std::vector<std::string> failures(count);
  progress.Start(2 * count);
  ParallelFor(count, num_threads, [&](std::size_t k) {
    const Keyframe& keyframe = input.keyframes[k];
    failures[k] = FrameFailure(keyframe.frame.color.path, [&] {
      const auto camera_idx = static_cast<std::size_t>(keyframe.frame.camera_idx);
      views[k] = MakeKeyframeView(
          keyframe, input.cameras[camera_idx], input.depth(keyframe), input.may_move(keyframe));
    });
    progress.Advance();
  });
  GhostsResult result;
  result.masks.resize(count);
  std::vector<int> num_ghosts(count);
  ParallelFor(count, num_threads, [&](std::size_t k) {
    const Keyframe& keyframe = input.keyframes[k];
    if (views[k]) {
      GrayImage mask = input.moving(keyframe);
      const std::vector<bool> are_ghosts = FindGhosts(options, views, k);
      num_ghosts[k] = static_cast<int>(std::ranges::count(are_ghosts, true));
      if (num_ghosts[k] > 0 && !mask.pixels.empty()) {
        AddGhosts(*views[k], are_ghosts, input.may_move(keyframe), &mask);
      }
      if (!mask.pixels.empty()) result.masks[k] = PackMask(keyframe.frame.time_ns, mask);
    }
    progress.Advance();
  });
  for (std::size_t k = 0; k < count; ++k) {
    if (views[k]) result.num_regions += static_cast<int>(views[k]->points.size());
    result.num_ghosts += num_ghosts[k];
    if (!failures[k].empty()) result.skipped.push_back(std::move(failures[k]));
  }
  return result;
}

}  // namespace nightmap
