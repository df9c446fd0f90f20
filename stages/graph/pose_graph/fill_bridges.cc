// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/fill_bridges.h"

#include <algorithm>
#include <iterator>
#include <optional>

namespace nightmap {
namespace {

class BridgeFiller {
 public:
  BridgeFiller(const EdgeSigmaFloor& floor, OdometryChain* chain) : floor_(floor), chain_(*chain) {}

  // The keyframe after the bridge that the stretch fills; none: it crosses none, or several.
  std::optional<int> Fill(const Stretch& stretch) {
    const auto start = chain_.after_bridge.upper_bound(stretch.edge.frame_a);
    if (start == chain_.after_bridge.end() || *start > stretch.edge.frame_b) return std::nullopt;
    const auto next = std::next(start);
    if (next != chain_.after_bridge.end() && *next <= stretch.edge.frame_b) return std::nullopt;
    const int first = *start;  // of the frames that move
    PlaceGuessed(stretch, first);
    Measure(stretch.edge, first);
    Interpolate(stretch.edge.frame_a + 1, first);
    chain_.after_bridge.erase(start);
    return first;
  }

 private:
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
    for (int idx = begin; idx < end; ++idx) {
      if (!chain_.guessed.contains(idx) || chain_.keyframes.contains(idx)) continue;
      int next = idx + 1;
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
    const auto bridge = std::ranges::find_if(chain_.edges, [&](const PoseEdge& edge) {
      return edge.is_bridge && edge.frame_b == first;
    });
    const int a = bridge->frame_a;
    const Rigid3 b_from_a = chain_.At(first).Inverse() * chain_.At(measured.frame_b) *
                            measured.b_from_a * chain_.At(measured.frame_a).Inverse() *
                            chain_.At(a);
    *bridge = WithSigmaFloor(floor_, {a, first, b_from_a, measured.covariance, false});
    const Rigid3 motion = chain_.At(a) * b_from_a.Inverse() * chain_.At(first).Inverse();
    for (auto i = static_cast<std::size_t>(first); i < chain_.graph_from_camera.size(); ++i) {
      chain_.graph_from_camera[i] = motion * chain_.graph_from_camera[i];
    }
  }

  const EdgeSigmaFloor& floor_;
  OdometryChain& chain_;
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
  }
  return filled;
}

}  // namespace nightmap
