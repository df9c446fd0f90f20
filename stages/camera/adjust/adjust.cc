// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/adjust.h"

#include <map>
#include <utility>

#include "pipeline/graph/frame_poses.h"
#include "stages/camera/adjust/adjust_rounds.h"
#include "stages/camera/adjust/check_tracks.h"
#include "stages/camera/adjust/cull_keyframes.h"
#include "stages/camera/adjust/edges_between_kept.h"
#include "stages/camera/adjust/merged_tracks.h"

namespace nightmap {
namespace {

class Pipeline {
 public:
  Pipeline(const AdjustOptions& options, const AdjustInput& input, int num_threads)
      : options_(options),
        input_(input),
        rounds_(options, input, num_threads),
        keyframes_(input.graph.graph_from_keyframe) {}

  AdjustResult Run(Progress& progress) {
    progress.Start(2);
    TrackList tracks = CullKeyframes();
    Note(rounds_.AdjustKeyframes(std::move(tracks), &keyframes_));
    result_.graph_from_camera = CarryFrames(input_.graph.chain, keyframes_);
    progress.Advance();
    if (options_.final_adjustment) {
      Note(rounds_.AdjustDescribed(&keyframes_, &result_.graph_from_camera));
    }
    for (const auto& [idx, pose] : keyframes_) result_.graph.vertices.push_back({idx, pose});
    result_.graph.edges = EdgesBetweenKept(input_.graph, input_.loops(), result_.keyframes);
    progress.Advance();
    return std::move(result_);
  }

 private:
  // Tracks of the keyframes that stay.
  TrackList CullKeyframes() {
    const std::set<int>& all = input_.graph.chain.keyframes;
    const TrackList tracks = MergeTracks(all);
    const auto redundant = RedundantKeyframes(tracks, all, BridgeEnds(), options_.max_seen_ratio);
    result_.keyframes = all;
    for (const int idx : redundant) {
      keyframes_.erase(idx);
      result_.keyframes.erase(idx);
    }
    result_.num_culled = static_cast<int>(redundant.size());
    return WithoutFrames(tracks, redundant);
  }

  TrackList MergeTracks(const std::set<int>& keyframes) const {
    const std::vector<FramePair> loops = input_.loops();
    CheckLoops(input_, loops);
    return nightmap::MergeTracks(input_, loops, keyframes);
  }

  std::set<int> BridgeEnds() const {
    std::set<int> ends;
    for (const PoseEdge& edge : input_.graph.chain.edges) {
      if (edge.is_bridge) ends.insert({edge.frame_a, edge.frame_b});
    }
    return ends;
  }

  void Note(const GlobalBundleSummary& summary) {
    result_.bundle_rms_px = summary.rms_px;
    result_.num_bundle_observations = summary.num_observations;
    result_.calibrations = summary.calibrations;
    result_.depth_offsets = summary.depth_offsets;
    result_.adjustments.insert(
        result_.adjustments.end(), summary.adjustments.begin(), summary.adjustments.end());
  }

  const AdjustOptions& options_;
  const AdjustInput& input_;
  AdjustmentRounds rounds_;
  std::map<int, Rigid3> keyframes_;  // graph_from_camera
  AdjustResult result_;
};

}  // namespace

AdjustResult RunAdjust(const AdjustOptions& options,
                       const AdjustInput& input,
                       Progress& progress,
                       int num_threads) {
  CheckFrames(input);
  return Pipeline(options, input, num_threads).Run(progress);
}

}  // namespace nightmap
