// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/check_tracks.h"

#include "pipeline/base/input_error.h"
#include "pipeline/graph/check_loop.h"

namespace nightmap {
namespace {

bool HasFeature(const SiteFeatures& features, const Sighting& s) {
  const auto place = static_cast<std::size_t>(s.frame_idx);
  return s.frame_idx >= 0 && place < features.Heads().frames.size() && s.feature_idx >= 0 &&
         s.feature_idx < features.NumFeatures(place);
}

void CheckMatches(const FramePair& loop, const SiteFeatures& features) {
  for (const FeatureMatch& match : loop.inliers) {
    if (HasFeature(features, {loop.frame_a, match.a}) &&
        HasFeature(features, {loop.frame_b, match.b})) {
      continue;
    }
    throw InputError({{"loops"}},
                     "loop {}-{} matches features {} and {}, which do not both exist",
                     loop.frame_a,
                     loop.frame_b,
                     match.a,
                     match.b);
  }
}

}  // namespace

void CheckFrames(const AdjustInput& input) {
  const std::size_t count = input.graph.chain.graph_from_camera.size();
  if (count != input.frames.size() || count != input.features.Heads().frames.size()) {
    throw InputError({{"graph"}, {"frames"}},
                     "{} frames are in the graph, the lists have {}, {} of them with features",
                     count,
                     input.frames.size(),
                     input.features.Heads().frames.size());
  }
  CheckFeaturesOfFrames(input.frames, input.features.Heads());
}

void CheckTracks(std::size_t shard_idx, const OdometryShard& shard, const SiteFeatures& features) {
  for (const Track& track : shard.tracks) {
    for (const Sighting& s : track) {
      if (HasFeature(features, s)) continue;
      throw InputError({{"odometry", shard_idx}},
                       "a track has feature {} of frame {}, which the {} frames do not have",
                       s.feature_idx,
                       s.frame_idx,
                       features.Heads().frames.size());
    }
  }
}

void CheckLoops(const AdjustInput& input, const std::vector<FramePair>& loops) {
  for (const FramePair& loop : loops) {
    CheckLoop(loop, input.frames.size());
    CheckMatches(loop, input.features);
  }
  if (input.graph.is_loop_accepted.size() == loops.size()) return;
  throw InputError({{"graph"}, {"loops"}},
                   "the graph judges {} loops, the list has {}",
                   input.graph.is_loop_accepted.size(),
                   loops.size());
}

}  // namespace nightmap
