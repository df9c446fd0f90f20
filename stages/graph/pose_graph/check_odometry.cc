// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/check_odometry.h"

#include "pipeline/base/input_error.h"
#include "pipeline/graph/check_loop.h"

namespace nightmap {
namespace {

// Whether each frame is a keyframe.
std::vector<bool> Keyframes(const std::vector<OdometryShard>& shards) {
  std::vector<bool> is_keyframe;
  for (std::size_t i = 0; i < shards.size(); ++i) {
    for (const OdometryFrame& frame : shards[i].frames) {
      if (frame.frame_idx != static_cast<int>(is_keyframe.size())) {
        throw InputError({{"odometry", i}},
                         "has frame {} where frame {} follows",
                         frame.frame_idx,
                         is_keyframe.size());
      }
      is_keyframe.push_back(frame.is_keyframe);
    }
  }
  return is_keyframe;
}

void CheckFrames(const PoseGraphInput& input, const std::vector<bool>& is_keyframe) {
  const std::size_t count = is_keyframe.size();
  if (count == 0 || count != input.frames.size()) {
    throw InputError({{"odometry"}, {"frames"}},
                     "{} frames have odometry, the lists have {}",
                     count,
                     input.frames.size());
  }
  if (!is_keyframe[0]) {
    throw InputError({{"odometry", 0}}, "frame 0, the first, is not a keyframe");
  }
}

void CheckEdge(std::size_t shard_idx,
               const OdometryShard& shard,
               const PoseEdge& edge,
               const std::vector<bool>& is_keyframe) {
  for (const int frame : {edge.frame_a, edge.frame_b}) {
    const bool exists = frame >= 0 && static_cast<std::size_t>(frame) < is_keyframe.size();
    if (exists && is_keyframe[static_cast<std::size_t>(frame)]) continue;
    throw InputError({{"odometry", shard_idx}},
                     "edge {}-{} ends at frame {}, which is not a keyframe",
                     edge.frame_a,
                     edge.frame_b,
                     frame);
  }
  const bool is_of_shard = edge.frame_b >= shard.frames.front().frame_idx &&
                           edge.frame_b <= shard.frames.back().frame_idx;
  if (edge.frame_a < edge.frame_b && is_of_shard) return;
  throw InputError({{"odometry", shard_idx}},
                   "edge {}-{} does not end in its shard, frames {} to {}",
                   edge.frame_a,
                   edge.frame_b,
                   shard.frames.front().frame_idx,
                   shard.frames.back().frame_idx);
}

void CheckEdges(std::size_t shard_idx,
                const OdometryShard& shard,
                const std::vector<bool>& is_keyframe) {
  if (shard.frames.empty()) {
    if (shard.edges.empty()) return;
    throw InputError({{"odometry", shard_idx}},
                     "has edge {}-{} and no frames",
                     shard.edges[0].frame_a,
                     shard.edges[0].frame_b);
  }
  for (const PoseEdge& edge : shard.edges) CheckEdge(shard_idx, shard, edge, is_keyframe);
  const int first = shard.frames[0].frame_idx;
  if (first > 0 && (shard.edges.empty() || shard.edges[0].frame_a >= first)) {
    throw InputError(
        {{"odometry", shard_idx}},
        "no edge joins the shard of frame {} to the one before, which ends with frame {}",
        first,
        first - 1);
  }
}

}  // namespace

void CheckInput(const PoseGraphInput& input) {
  const std::vector<bool> is_keyframe = Keyframes(input.odometry);
  CheckFrames(input, is_keyframe);
  for (std::size_t i = 0; i < input.odometry.size(); ++i) {
    CheckEdges(i, input.odometry[i], is_keyframe);
  }
  for (const FramePair& loop : input.loops) CheckLoop(loop, is_keyframe.size());
}

}  // namespace nightmap
