// SPDX-License-Identifier: Apache-2.0
#include "pipeline/graph/frame_poses.h"

#include <iterator>
#include <utility>

#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

Rigid3 Carried(const OdometryChain& chain,
               const std::pair<const int, Rigid3>& known,
               int frame_idx) {
  return known.second * chain.At(known.first).Inverse() * chain.At(frame_idx);
}

std::string Text(const std::vector<StampedPose>& poses) {
  // map_frame moves these poses, so they must not be rounded before its own output is.
  constexpr int kNumDecimals = 15;
  return TrajectoryToTum(poses, "graph_from_camera, in no frame of its own", kNumDecimals);
}

}  // namespace

std::vector<Rigid3> CarryFrames(const OdometryChain& chain, const std::map<int, Rigid3>& poses) {
  std::vector<Rigid3> graph_from_camera;
  for (int idx = 0; idx < static_cast<int>(chain.graph_from_camera.size()); ++idx) {
    const auto after = poses.lower_bound(idx);
    const auto before = after == poses.begin() ? after : std::prev(poses.upper_bound(idx));
    const Rigid3 by_before = Carried(chain, *before, idx);
    if (after == poses.end() || after == before || chain.IsBridged(before->first, after->first)) {
      graph_from_camera.push_back(by_before);
      continue;
    }
    const double fraction = static_cast<double>(idx - before->first) /
                            static_cast<double>(after->first - before->first);
    const Rigid3 by_after = Carried(chain, *after, idx);
    graph_from_camera.push_back(
        {by_before.rotation.slerp(fraction, by_after.rotation),
         (1 - fraction) * by_before.translation + fraction * by_after.translation});
  }
  return graph_from_camera;
}

std::string TrajectoryText(const std::vector<FrameRecord>& frames,
                           const std::vector<Rigid3>& graph_from_camera) {
  std::vector<StampedPose> poses;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    poses.push_back({frames[i].time_ns, graph_from_camera[i]});
  }
  return Text(poses);
}

std::string KeyframesText(const std::vector<FrameRecord>& frames,
                          const std::vector<Rigid3>& graph_from_camera,
                          const std::set<int>& keyframes) {
  std::vector<StampedPose> poses;
  for (const int idx : keyframes) {
    const auto i = static_cast<std::size_t>(idx);
    poses.push_back({frames[i].time_ns, graph_from_camera[i]});
  }
  return Text(poses);
}

}  // namespace nightmap
