// SPDX-License-Identifier: Apache-2.0
// A camera that drives one turn of a circle: its odometry drifts, and loops close the circle.
#pragma once

#include <algorithm>
#include <numbers>

#include "pipeline/base/random.h"
#include "stages/graph/pose_graph/pose_graph.h"
#include "tests/test_data.h"

namespace nightmap {

inline constexpr int kNumFrames = 48;

// One turn of a circle, looking outwards: 7.5 degrees a frame.
inline Rigid3 TruePose(int i) {
  const double angle = 2 * std::numbers::pi * i / kNumFrames;
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
          {2 * std::sin(angle), 0, 2 * std::cos(angle)}};
}

inline Rigid3 TrueRelative(int a, int b) { return TruePose(b).Inverse() * TruePose(a); }

inline std::int64_t TimeAt(int frame_idx) { return 1000000000LL * (frame_idx + 1); }

// Exact, of a sensor that knows its error.
inline SensorEdge MakeEdge(EdgeKind kind, int source, int target, double variance = 1e-6) {
  return {kind,
          TimeAt(source),
          TimeAt(target),
          TrueRelative(source, target),
          variance * Matrix6d::Identity()};
}

// The poses of some frames, as a survey knows them.
inline SensorEdges Survey(const std::vector<int>& frames, const Rigid3& map_from_truth = {}) {
  SensorEdges survey{"survey", {}};
  for (const int i : frames) {
    survey.edges.push_back(MakeEdge(EdgeKind::kPrior, i, i));
    survey.edges.back().target_from_source = map_from_truth * TruePose(i);
  }
  return survey;
}

// Two shards of drifting odometry, every third frame a keyframe, and loops of the last frames with
// the first.
inline PoseGraphInput MakeInput(int num_loops = 4) {
  PoseGraphInput input;
  Random random(6);
  for (int begin = 0; begin < kNumFrames; begin += kNumFrames / 2) {
    OdometryShard shard;
    Rigid3 pose;
    int keyframe = begin - 1;
    Rigid3 keyframe_pose;
    for (int i = begin; i < begin + kNumFrames / 2; ++i) {
      Rigid3 relative = i == 0 ? Rigid3() : TrueRelative(i - 1, i);
      relative.translation.x() += 0.01 * random.Gaussian();
      relative.translation.z() += 0.01 * random.Gaussian();
      if (i == 0) relative = Rigid3();
      pose = pose * relative.Inverse();
      const bool is_keyframe = i % 3 == 0 || i + 1 == begin + kNumFrames / 2;
      shard.frames.push_back({i, pose, TrackingState::kTracked, is_keyframe});
      if (is_keyframe) {
        if (keyframe >= 0) {
          shard.edges.push_back(
              {keyframe, i, pose.Inverse() * keyframe_pose, 1e-3 * Matrix6d::Identity(), false});
        }
        keyframe = i;
        keyframe_pose = pose;
      }
      input.frames.push_back({i, TimeAt(i), 0, 0, {}, {}, {}});
    }
    input.odometry.push_back(shard);
  }
  for (int k = 0; k < num_loops; ++k) {
    CountedPair loop;
    loop.frame_a = k;
    loop.frame_b = kNumFrames - 4 + k;
    loop.status = PairStatus::kAccepted;
    loop.b_from_a = TrueRelative(loop.frame_a, loop.frame_b);
    loop.covariance = 1e-5 * Matrix6d::Identity();
    input.loops.push_back(loop);
  }
  return input;
}

inline PoseGraphResult Optimize(const PoseGraphInput& input, const PoseGraphOptions& options = {}) {
  return RunPoseGraph(options, input, NoProgress());
}

template <typename Result>
double WorstError_m(const Result& result) {
  const Rigid3 graph_from_truth = result.graph_from_camera[0] * TruePose(0).Inverse();
  double worst = 0;
  for (int i = 0; i < kNumFrames; ++i) {
    worst = std::max(worst,
                     (result.graph_from_camera[static_cast<std::size_t>(i)].translation -
                      (graph_from_truth * TruePose(i)).translation)
                         .norm());
  }
  return worst;
}

inline Rigid3 Elsewhere() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(1, Eigen::Vector3d::UnitX())), {4, -2, 1}};
}

// The camera was lost before frame 12; odometry goes on somewhere else.
inline PoseGraphInput MakeBrokenInput(int num_loops = 4) {
  PoseGraphInput input = MakeInput(num_loops);
  OdometryShard& shard = input.odometry[0];
  for (OdometryFrame& frame : shard.frames) {
    if (frame.frame_idx >= 12) frame.shard_from_camera = Elsewhere() * frame.shard_from_camera;
  }
  for (PoseEdge& edge : shard.edges) {
    if (edge.frame_b != 12) continue;
    edge.is_bridge = true;
    edge.covariance = 100 * Matrix6d::Identity();
    edge.b_from_a =
        shard.frames[12].shard_from_camera.Inverse() * shard.frames[9].shard_from_camera;
  }
  return input;
}

}  // namespace nightmap
