// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/check_odometry.h"

#include "pipeline/base/error.h"
#include "pipeline/io/features_io.h"

namespace nightmap {
namespace {

constexpr const char* kRemedy = "delete the odometry folder of this site and run make";

// Whether each frame is a keyframe.
std::vector<bool> Keyframes(const std::vector<OdometryShard>& shards) {
  std::vector<bool> is_keyframe;
  for (const OdometryShard& shard : shards) {
    for (const OdometryFrame& frame : shard.frames) {
      if (frame.frame_idx != static_cast<int>(is_keyframe.size())) {
        throw DataError("odometry has frame {} where frame {} follows; {}",
                        frame.frame_idx,
                        is_keyframe.size(),
                        kRemedy);
      }
      is_keyframe.push_back(frame.is_keyframe);
    }
  }
  return is_keyframe;
}

void CheckFrames(const PoseGraphInput& input, const std::vector<bool>& is_keyframe) {
  const std::size_t count = is_keyframe.size();
  if (count == 0 || count != input.frames.size() || count != input.features.frames.size()) {
    throw DataError("{} frames, {} with features, {} with odometry; {}",
                    input.frames.size(),
                    input.features.frames.size(),
                    count,
                    kRemedy);
  }
  if (!is_keyframe[0]) {
    throw DataError("odometry: frame 0, the first, is not a keyframe; {}", kRemedy);
  }
  CheckFeaturesOfFrames(input.frames, input.features);
}

void CheckEdge(const OdometryShard& shard,
               const PoseEdge& edge,
               const std::vector<bool>& is_keyframe) {
  for (const int frame : {edge.frame_a, edge.frame_b}) {
    const bool exists = frame >= 0 && static_cast<std::size_t>(frame) < is_keyframe.size();
    if (exists && is_keyframe[static_cast<std::size_t>(frame)]) continue;
    throw DataError("odometry: edge {}-{} ends at frame {}, which is not a keyframe; {}",
                    edge.frame_a,
                    edge.frame_b,
                    frame,
                    kRemedy);
  }
  const bool is_of_shard = edge.frame_b >= shard.frames.front().frame_idx &&
                           edge.frame_b <= shard.frames.back().frame_idx;
  if (edge.frame_a < edge.frame_b && is_of_shard) return;
  throw DataError("odometry: edge {}-{} does not end in its shard, frames {} to {}; {}",
                  edge.frame_a,
                  edge.frame_b,
                  shard.frames.front().frame_idx,
                  shard.frames.back().frame_idx,
                  kRemedy);
}

void CheckEdges(const OdometryShard& shard, const std::vector<bool>& is_keyframe) {
  if (shard.frames.empty()) {
    if (shard.edges.empty()) return;
    throw DataError("odometry: a shard has edge {}-{} and no frames; {}",
                    shard.edges[0].frame_a,
                    shard.edges[0].frame_b,
                    kRemedy);
  }
  for (const PoseEdge& edge : shard.edges) CheckEdge(shard, edge, is_keyframe);
  const int first = shard.frames[0].frame_idx;
  if (first > 0 && (shard.edges.empty() || shard.edges[0].frame_a >= first)) {
    throw DataError(
        "odometry: no edge joins the shard of frame {} to the one before; {}", first, kRemedy);
  }
}

bool HasFeature(const FeaturesShard& features, const Sighting& s) {
  if (s.frame_idx < 0 || static_cast<std::size_t>(s.frame_idx) >= features.frames.size()) {
    return false;
  }
  const FrameFeatures& frame = features.frames[static_cast<std::size_t>(s.frame_idx)];
  return s.feature_idx >= 0 && s.feature_idx < frame.NumFeatures();
}

void CheckTracks(const OdometryShard& shard, const FeaturesShard& features) {
  for (const Track& track : shard.tracks) {
    for (const Sighting& s : track) {
      if (HasFeature(features, s)) continue;
      throw DataError(
          "odometry: a track has feature {} of frame {}, which the {} frames do not have; {}",
          s.feature_idx,
          s.frame_idx,
          features.frames.size(),
          kRemedy);
    }
  }
}

void CheckMatches(const FramePair& loop, const FeaturesShard& features) {
  for (const FeatureMatch& match : loop.inliers) {
    if (HasFeature(features, {loop.frame_a, match.a}) &&
        HasFeature(features, {loop.frame_b, match.b})) {
      continue;
    }
    throw DataError(
        "loop {}-{} matches features {} and {}, which do not both exist; delete the matches folder "
        "of this site and run make",
        loop.frame_a,
        loop.frame_b,
        match.a,
        match.b);
  }
}

void CheckLoops(const std::vector<FramePair>& loops, std::size_t num_frames) {
  for (const FramePair& loop : loops) {
    if (loop.frame_a >= 0 && loop.frame_a < loop.frame_b &&
        static_cast<std::size_t>(loop.frame_b) < num_frames) {
      continue;
    }
    throw DataError(
        "loop {}-{} is not between frames of this site; delete the matches folder of this site "
        "and run make",
        loop.frame_a,
        loop.frame_b);
  }
}

}  // namespace

void CheckInput(const PoseGraphInput& input) {
  const std::vector<bool> is_keyframe = Keyframes(input.odometry);
  CheckFrames(input, is_keyframe);
  for (const OdometryShard& shard : input.odometry) {
    CheckEdges(shard, is_keyframe);
    CheckTracks(shard, input.features);
  }
  CheckLoops(input.loops, is_keyframe.size());
  for (const FramePair& loop : input.loops) CheckMatches(loop, input.features);
}

}  // namespace nightmap
