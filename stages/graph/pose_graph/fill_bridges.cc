// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/fill_bridges.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>

namespace nightmap {
namespace {

class BridgeFiller {
 public:
  BridgeFiller(const EdgeSigmaFloor& floor, OdometryChain* chain) : floor_(floor), chain_(*chain) {
    for (std::size_t i = 0; i < chain_.edges.size(); ++i) {
      if (chain_.edges[i].is_bridge) bridge_to_.emplace(chain_.edges[i].frame_b, i);
    }
  }

  // The keyframe after the bridge that the stretch fills; none: it crosses none, or several.
  // Stretches ascend; then Finish follows.
  std::optional<int> Fill(const Stretch& stretch) {
    const auto start = chain_.after_bridge.upper_bound(stretch.edge.frame_a);
    if (start == chain_.after_bridge.end() || *start > stretch.edge.frame_b) return std::nullopt;
    const auto next = std::next(start);
    if (next != chain_.after_bridge.end() && *next <= stretch.edge.frame_b) return std::nullopt;
    const int first = *start;  // of the frames that move
    MoveUpTo(stretch.edge.frame_b + 1);
    PlaceGuessed(stretch, first);
    Measure(stretch.edge, first);
    Interpolate(stretch.edge.frame_a + 1, first);
    chain_.after_bridge.erase(start);
    return first;
  }

  void Finish() {
    MoveUpTo(static_cast<int>(chain_.graph_from_camera.size()));
    motion_.reset();
    num_moved_ = 0;
  }

 private:
  // Frames move along with the bridges before them only when they are needed: each frame once,
  // however many bridges there are.
  void MoveUpTo(int end) {
    for (int idx = num_moved_; motion_ && idx < end; ++idx) Move(*motion_, idx);
    num_moved_ = std::max(num_moved_, end);
  }

  void Move(const Rigid3& motion, int frame_idx) {
    Rigid3& pose = chain_.graph_from_camera[static_cast<std::size_t>(frame_idx)];
    pose = motion * pose;
  }

  void PlaceGuessed(const Stretch& stretch, int end) {
    Rigid3 pose = chain_.At(stretch.edge.frame_a);
    for (const PoseEdge& step : stretch.steps) {
      pose = pose * step.b_from_a.Inverse();
      if (step.frame_b >= end || chain_.guessed.erase(step.frame_b) == 0) continue;
      chain_.graph_from_camera[static_cast<std::size_t>(step.frame_b)] = pose;
    }
  }

  // Frames in between that are no nodes.
  void Interpolate(int begin, int end) {
    int next = begin;  // the first frame after idx that is placed
    for (int idx = begin; idx < end; ++idx) {
      if (!chain_.guessed.contains(idx) || chain_.keyframes.contains(idx)) continue;
      next = std::max(next, idx + 1);
      while (next < end && chain_.guessed.contains(next)) ++next;
      const double fraction = 1.0 / (next - idx + 1);
      const Rigid3& a = chain_.At(idx - 1);
      const Rigid3& b = chain_.At(next);
      chain_.graph_from_camera[static_cast<std::size_t>(idx)] = {
          a.rotation.slerp(fraction, b.rotation),
          (1 - fraction) * a.translation + fraction * b.translation};
    }
  }

  void Measure(const PoseEdge& measured, int first) {
    PoseEdge* const bridge = &chain_.edges[bridge_to_.at(first)];
    const int a = bridge->frame_a;
    const Rigid3 b_from_a = chain_.At(first).Inverse() * chain_.At(measured.frame_b) *
                            measured.b_from_a * chain_.At(measured.frame_a).Inverse() *
                            chain_.At(a);
    *bridge = WithSigmaFloor(floor_, {a, first, b_from_a, measured.covariance, false});
    const Rigid3 motion = chain_.At(a) * b_from_a.Inverse() * chain_.At(first).Inverse();
    for (int idx = first; idx < num_moved_; ++idx) Move(motion, idx);
    motion_ = motion_ ? motion * *motion_ : motion;
  }

  const EdgeSigmaFloor& floor_;
  OdometryChain& chain_;
  std::map<int, std::size_t> bridge_to_;  // index among the chain's edges, by keyframe after it
  std::optional<Rigid3> motion_;          // of the frames from num_moved_ on, which is due
  int num_moved_ = 0;
};

}  // namespace

FilledBridges FillBridges(const EdgeSigmaFloor& floor,
                          const std::vector<SensorGraph>& sensors,
                          OdometryChain* chain) {
  FilledBridges filled;
  BridgeFiller filler(floor, chain);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    for (const Stretch& stretch : CutAtKeyframes(*chain, chain->keyframes, sensors[i].odometry)) {
      if (const auto start = filler.Fill(stretch)) filled.emplace(*start, i);
    }
    filler.Finish();
  }
  return filled;
}

}  // namespace nightmap
