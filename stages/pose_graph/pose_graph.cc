// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/pose_graph.h"

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/base/union_find.h"
#include "stages/pose_graph/check_input.h"
#include "stages/pose_graph/cull_keyframes.h"
#include "stages/pose_graph/drift_gate.h"
#include "stages/pose_graph/global_bundle.h"
#include "stages/pose_graph/join_runs.h"
#include "stages/pose_graph/optimize_graph.h"
#include "stages/pose_graph/retrack.h"

namespace nightmap {
namespace {

class Pipeline {
 public:
  Pipeline(const PoseGraphOptions& options, const PoseGraphInput& input, int num_threads)
      : options_(options), input_(input), num_threads_(num_threads), chained_(input.frames.size()) {
    result_.is_keyframe.assign(input.frames.size(), false);
  }

  PoseGraphResult Run(Progress& progress) {
    progress.Start(4);
    ChainShards();
    AddLoops();
    progress.Advance();
    OptimizeGraph(options_.max_loop_error, &edges_, &keyframes_);
    JudgeLoops();
    FindParts();
    progress.Advance();
    auto tracks = MergeTracks(input_.odometry, input_.loops, AcceptedLoops(), KeyframeIdxs());
    const auto redundant =
        RedundantKeyframes(tracks, KeyframeIdxs(), BridgeEnds(), options_.max_seen_ratio);
    Cull(redundant);
    if (options_.bundle_adjustment) {
      AdjustKeyframes(WithoutFrames(std::move(tracks), redundant));
    }
    CarryFrames(keyframes_);
    if (options_.bundle_adjustment && options_.final_adjustment) AdjustDescribed();
    progress.Advance();
    TurnIntoMapFrame();
    return std::move(result_);
  }

 private:
  // Poses of all frames in the first shard's frame of reference, by each shard's first edge.
  void ChainShards() {
    for (const OdometryShard& shard : input_.odometry) {
      Rigid3 graph_from_shard;
      if (!shard.edges.empty() && shard.edges[0].frame_a < shard.frames[0].frame_idx) {
        const PoseEdge& join = shard.edges[0];
        const auto b = static_cast<std::size_t>(join.frame_b - shard.frames[0].frame_idx);
        graph_from_shard = Chained(join.frame_a) * join.b_from_a.Inverse() *
                           shard.frames.at(b).shard_from_camera.Inverse();
      }
      for (const OdometryFrame& frame : shard.frames) {
        Chained(frame.frame_idx) = graph_from_shard * frame.shard_from_camera;
        if (!frame.is_keyframe) continue;
        keyframes_[frame.frame_idx] = Chained(frame.frame_idx);
        result_.is_keyframe[static_cast<std::size_t>(frame.frame_idx)] = true;
      }
      for (const PoseEdge& edge : shard.edges) {
        odometry_.push_back(WithFloor(edge));
        if (edge.is_bridge) after_bridge_.insert(edge.frame_b);
      }
    }
  }

  Rigid3& Chained(int frame_idx) { return chained_[static_cast<std::size_t>(frame_idx)]; }

  // Calibration and synchronization errors do not show in an edge's own Hessian.
  PoseEdge WithFloor(PoseEdge edge) const {
    const double rad2 = options_.edge_sigma_floor_rad * options_.edge_sigma_floor_rad;
    const double m2 = options_.edge_sigma_floor_m * options_.edge_sigma_floor_m;
    edge.covariance.diagonal().head<3>().array() += rad2;
    edge.covariance.diagonal().tail<3>().array() += m2;
    return edge;
  }

  int KeyframeAtOrBefore(int frame_idx) const {
    return std::prev(keyframes_.upper_bound(frame_idx))->first;
  }
  // Not across a bridge: odometry does not know the way.
  int NearestKeyframe(int frame_idx) const {
    const int before = KeyframeAtOrBefore(frame_idx);
    const auto after = keyframes_.lower_bound(frame_idx);
    if (after == keyframes_.end() || IsBridged(before, after->first)) return before;
    return after->first - frame_idx < frame_idx - before ? after->first : before;
  }

  bool IsBridged(int before, int after) const {
    return before < after && after_bridge_.contains(after);
  }

  // A loop joins two frames; its edge joins the keyframes they are nearest to.
  std::optional<PoseEdge> LoopEdge(const FramePair& loop) {
    const int a = NearestKeyframe(loop.frame_a);
    const int b = NearestKeyframe(loop.frame_b);
    if (loop.status != PairStatus::kAccepted || a >= b) return std::nullopt;
    const Rigid3 b_from_a = Chained(b).Inverse() * Chained(loop.frame_b) * loop.b_from_a *
                            Chained(loop.frame_a).Inverse() * Chained(a);
    return WithFloor({a, b, b_from_a, loop.covariance, false});
  }

  // Of the loops, only those that the drift of the odometry allows; then again, with the runs where
  // the loops want them.
  void AddLoops() {
    std::vector<std::optional<PoseEdge>> loops;
    for (const FramePair& loop : input_.loops) loops.push_back(LoopEdge(loop));
    const DriftGate by_odometry(odometry_);
    std::vector<PoseEdge> possible;
    for (const auto& loop : loops) {
      if (loop && by_odometry.Distance(*loop) <= options_.max_drift) possible.push_back(*loop);
    }
    const std::vector<PoseEdge> tree = JoinRuns(odometry_, possible, options_.max_drift);
    const DriftGate gate(tree);
    const Rigid3 first = keyframes_.begin()->second;
    for (const auto& [idx, pose] : gate.Poses()) keyframes_.at(idx) = first * pose;
    for (const PoseEdge& edge : odometry_) {
      if (!edge.is_bridge || IsIn(tree, edge)) edges_.push_back({edge, false});
    }
    for (const auto& loop : loops) {
      drifts_.push_back(loop ? std::max(by_odometry.Distance(*loop), gate.Distance(*loop)) : 0);
      const bool is_possible = loop && drifts_.back() <= options_.max_drift;
      loop_edge_.push_back(is_possible ? static_cast<int>(edges_.size()) : -1);
      if (is_possible) edges_.push_back({*loop, true});
    }
  }

  static bool IsIn(const std::vector<PoseEdge>& tree, const PoseEdge& bridge) {
    return std::ranges::any_of(tree, [&](const PoseEdge& edge) {
      return edge.is_bridge && edge.frame_b == bridge.frame_b;
    });
  }

  void JudgeLoops() {
    for (std::size_t i = 0; i < input_.loops.size(); ++i) {
      const FramePair& loop = input_.loops[i];
      LoopRecord record{loop.frame_a,
                        loop.frame_b,
                        loop.score,
                        loop.num_putative,
                        static_cast<int>(loop.inliers.size()),
                        drifts_[i],
                        0,
                        false,
                        ""};
      if (loop.status != PairStatus::kAccepted) {
        record.reason = PairStatusText(loop.status);
      } else if (drifts_[i] > options_.max_drift) {
        record.reason = "farther off than the odometry can have drifted";
      } else if (loop_edge_[i] < 0) {
        record.reason = "both ends are one keyframe";
      } else {
        const GraphEdge& edge = edges_[static_cast<std::size_t>(loop_edge_[i])];
        record.error = edge.error;
        record.is_accepted = IsBelieved(edge);
        if (!record.is_accepted) record.reason = "contradicts the rest of the graph";
      }
      result_.loops.push_back(record);
    }
  }

  bool IsBelieved(const GraphEdge& edge) const { return !edge.is_loop || edge.weight > 0.5; }

  void FindParts() {
    std::map<int, std::size_t> position;
    for (const auto& [idx, pose] : keyframes_) position.emplace(idx, position.size());
    UnionFind sets(position.size());
    for (const GraphEdge& edge : edges_) {
      if (edge.edge.is_bridge || !IsBelieved(edge)) continue;
      const std::size_t a = position.at(edge.edge.frame_a);
      const std::size_t b = position.at(edge.edge.frame_b);
      sets.Join(a, b);
      const bool is_loop_to_start = 10 * a < position.size() && 10 * b >= 9 * position.size();
      result_.returns_to_start |= edge.is_loop && is_loop_to_start;
    }
    std::map<std::size_t, GraphPart> parts;
    for (int idx = 0; idx < static_cast<int>(chained_.size()); ++idx) {
      GraphPart& part = parts[sets.Find(position.at(KeyframeAtOrBefore(idx)))];
      ++part.num_frames;
      if (part.runs.empty() || part.runs.back().second + 1 < idx) part.runs.push_back({idx, idx});
      part.runs.back().second = idx;
    }
    for (auto& [root, part] : parts) result_.parts.push_back(std::move(part));
    std::ranges::stable_sort(result_.parts, std::greater<>(), &GraphPart::num_frames);
  }

  std::vector<bool> AcceptedLoops() const {
    std::vector<bool> is_accepted;
    for (const LoopRecord& loop : result_.loops) is_accepted.push_back(loop.is_accepted);
    return is_accepted;
  }

  std::set<int> KeyframeIdxs() const {
    std::set<int> idxs;
    for (const auto& [idx, pose] : keyframes_) idxs.insert(idx);
    return idxs;
  }

  std::set<int> BridgeEnds() const {
    std::set<int> ends;
    for (const PoseEdge& edge : odometry_) {
      if (edge.is_bridge) ends.insert({edge.frame_a, edge.frame_b});
    }
    return ends;
  }

  // Edges of odometry go past a dropped keyframe; loops go to the one that is nearest now.
  void Cull(const std::set<int>& redundant) {
    for (const int idx : redundant) {
      keyframes_.erase(idx);
      result_.is_keyframe[static_cast<std::size_t>(idx)] = false;
    }
    result_.num_culled = static_cast<int>(redundant.size());
    std::vector<GraphEdge> edges;
    for (const GraphEdge& edge : edges_) {
      if (edge.is_loop) continue;
      const bool goes_on = redundant.contains(edge.edge.frame_a);
      edges.push_back({goes_on ? Chain(edges.back().edge, edge.edge) : edge.edge, false});
      if (goes_on) edges.erase(edges.end() - 2);
    }
    for (std::size_t i = 0; i < input_.loops.size(); ++i) {
      if (!result_.loops[i].is_accepted) continue;
      if (const auto edge = LoopEdge(input_.loops[i])) edges.push_back({*edge, true});
    }
    edges_ = std::move(edges);
  }

  static PoseEdge Chain(const PoseEdge& first, const PoseEdge& second) {
    const Matrix6d adjoint = Adjoint(second.b_from_a);
    return {first.frame_a,
            second.frame_b,
            second.b_from_a * first.b_from_a,
            second.covariance + adjoint * first.covariance * adjoint.transpose(),
            false};
  }

  BundleOptions MakeBundleOptions() const {
    BundleOptions bundle_options;
    bundle_options.max_iterations = options_.bundle_iterations;
    bundle_options.estimate_depth_scales = options_.estimate_depth_scales;
    bundle_options.num_threads = num_threads_;
    return bundle_options;
  }

  void Note(const GlobalBundleSummary& summary) {
    result_.bundle_rms_px = summary.rms_px;
    result_.num_bundle_observations = summary.num_observations;
    result_.calibrations = summary.calibrations;
  }

  void AdjustKeyframes(std::vector<Track> tracks) {
    Note(AdjustFrames(options_, input_, MakeBundleOptions(), std::move(tracks), {}, &keyframes_));
  }

  // Where most observations are good, those that are not need no say.
  void AdjustDescribed() {
    BundleOptions bundle_options = MakeBundleOptions();
    bundle_options.loss = RobustLoss::kCauchy;
    bundle_options.calibrate = options_.calibrate;
    std::map<int, Rigid3> poses = keyframes_;
    std::map<int, PointMotion> motions;
    for (const FrameFeatures& frame : input_.features.frames) {
      const auto i = static_cast<std::size_t>(frame.frame_idx);
      if (frame.IsDescribed()) poses.emplace(frame.frame_idx, result_.map_from_camera[i]);
    }
    for (const auto& [idx, pose] : poses) motions[idx] = MotionAt(idx);
    auto tracks = Retrack(input_, poses, options_.retrack);
    const auto summary =
        AdjustFrames(options_, input_, bundle_options, std::move(tracks), motions, &poses);
    Note(summary);
    for (auto& [idx, pose] : keyframes_) pose = poses.at(idx);
    CarryFrames(poses);
  }

  // From the frame before to the one after, by odometry; none across a gap.
  PointMotion MotionAt(int idx) {
    constexpr double kMaxGap_s = 0.5;
    const int first = std::max(0, idx - 1);
    const int last = std::min(static_cast<int>(chained_.size()) - 1, idx + 1);
    const double gap_s = 1e-9 * static_cast<double>(Time_ns(last) - Time_ns(first));
    const bool is_bridged = after_bridge_.contains(idx) || after_bridge_.contains(last);
    if (gap_s <= 0 || gap_s > kMaxGap_s || is_bridged) return {};
    const Rigid3 last_from_first = Chained(last).Inverse() * Chained(first);
    const Eigen::AngleAxisd turn(last_from_first.rotation);
    return {turn.angle() / gap_s * turn.axis(), last_from_first.translation / gap_s};
  }

  std::int64_t Time_ns(int idx) const {
    return input_.frames[static_cast<std::size_t>(idx)].time_ns;
  }

  // A frame keeps its odometry pose relative to the adjusted frames around it; between two it
  // follows both in proportion, so that the trajectory stays smooth. Before a bridge it follows the
  // one before it alone.
  void CarryFrames(const std::map<int, Rigid3>& adjusted) {
    result_.map_from_camera.clear();
    for (int idx = 0; idx < static_cast<int>(chained_.size()); ++idx) {
      const auto after = adjusted.lower_bound(idx);
      const auto before = after == adjusted.begin() ? after : std::prev(adjusted.upper_bound(idx));
      const Rigid3 by_before = Carried(*before, idx);
      if (after == adjusted.end() || after == before || IsBridged(before->first, after->first)) {
        result_.map_from_camera.push_back(by_before);
        continue;
      }
      const double fraction = static_cast<double>(idx - before->first) /
                              static_cast<double>(after->first - before->first);
      const Rigid3 by_after = Carried(*after, idx);
      result_.map_from_camera.push_back(
          {by_before.rotation.slerp(fraction, by_after.rotation),
           (1 - fraction) * by_before.translation + fraction * by_after.translation});
    }
  }

  Rigid3 Carried(const std::pair<const int, Rigid3>& adjusted, int idx) {
    return adjusted.second * Chained(adjusted.first).Inverse() * Chained(idx);
  }

  std::vector<SurfacePatch> Patches() const {
    std::vector<int> chosen;
    const std::size_t step =
        keyframes_.size() / static_cast<std::size_t>(options_.map_frame.floor_num_keyframes) + 1;
    std::size_t i = 0;
    for (const auto& [idx, pose] : keyframes_) {
      if (i++ % step == 0) chosen.push_back(idx);
    }
    std::vector<std::vector<SurfacePatch>> of_keyframe(chosen.size());
    ParallelFor(chosen.size(), num_threads_, [&](std::size_t k) {
      const FrameRecord& frame = input_.frames[static_cast<std::size_t>(chosen[k])];
      try {
        of_keyframe[k] =
            SamplePatches(input_.load_depth(frame),
                          input_.cameras.at(static_cast<std::size_t>(frame.camera_idx)),
                          keyframes_.at(chosen[k]),
                          options_.map_frame.floor_max_depth_m);
      } catch (const DataError&) {
        // The features stage has counted this frame as unreadable; the floor is seen by others.
      }
    });
    std::vector<SurfacePatch> patches;
    for (const auto& part : of_keyframe) patches.insert(patches.end(), part.begin(), part.end());
    return patches;
  }

  std::optional<Eigen::Vector3d> UpInGraph() const {
    if (input_.accelerometer.empty()) return std::nullopt;
    std::vector<StampedPose> keyframes;
    for (const auto& [idx, pose] : keyframes_) {
      keyframes.push_back({input_.frames[static_cast<std::size_t>(idx)].time_ns, pose});
    }
    return UpFromAccelerometer(input_.accelerometer, keyframes);
  }

  void TurnIntoMapFrame() {
    std::vector<Rigid3> cameras;
    for (const auto& [idx, pose] : keyframes_) cameras.push_back(pose);
    result_.map_frame = FindMapFrame(options_.map_frame, Patches(), cameras, UpInGraph());
    const Rigid3& map_from_graph = result_.map_frame.map_from_graph;
    for (Rigid3& pose : result_.map_from_camera) pose = map_from_graph * pose;
    for (const auto& [idx, pose] : keyframes_) {
      result_.graph.vertices.push_back({idx, map_from_graph * pose});
    }
    for (const GraphEdge& edge : edges_) {
      if (IsBelieved(edge)) result_.graph.edges.push_back(edge.edge);
    }
  }

  const PoseGraphOptions& options_;
  const PoseGraphInput& input_;
  int num_threads_;
  std::vector<Rigid3> chained_;      // graph_from_camera by odometry alone
  std::map<int, Rigid3> keyframes_;  // graph_from_camera, optimized
  std::vector<PoseEdge> odometry_;
  std::vector<GraphEdge>
      edges_;                   // odometry, without the bridges that loops stand in for, and loops
  std::set<int> after_bridge_;  // keyframes that only a guess joins to the one before
  std::vector<int> loop_edge_;  // of each candidate; -1: none
  std::vector<double> drifts_;  // of each candidate
  PoseGraphResult result_;
};

}  // namespace

PoseGraphResult RunPoseGraph(const PoseGraphOptions& options,
                             const PoseGraphInput& input,
                             int num_threads,
                             Progress& progress) {
  CheckInput(input);
  return Pipeline(options, input, num_threads).Run(progress);
}

}  // namespace nightmap
