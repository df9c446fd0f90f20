// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/odometry/odometry.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "pipeline/base/input_error.h"
#include "pipeline/geometry/absolute_pose.h"
#include "pipeline/io/features_io.h"
#include "stages/camera/odometry/initial_poses.h"
#include "stages/camera/odometry/shard_bundle.h"

namespace nightmap {
namespace {

// Share of the last keyframe's tracks below which a new one starts.
constexpr double kKeyframeMinOverlap = 0.5;
// Standard deviation of the velocity through a gap in the tracking.
constexpr double kBridge_m_per_s = 1.0;
constexpr double kBridge_rad_per_s = 1.0;  // and of the turning speed

using TracksOfFrames = std::vector<std::map<int, int>>;  // by frame: track -> feature

// Chooses keyframes and makes the edges between them from adjusted poses.
class KeyframeGraph {
 public:
  KeyframeGraph(const OdometryOptions& options,
                const OdometryInput& input,
                const std::vector<ChainedFrame>& frames,
                const ShardBundle& bundle)
      : options_(options),
        input_(input),
        frames_(frames),
        bundle_(bundle),
        begin_idx_(input.frames.front().frame_idx),
        tracks_(frames.size()) {
    for (std::size_t track = 0; track < bundle.tracks.size(); ++track) {
      for (const Sighting& s : bundle.tracks[track]) {
        tracks_[At(s.frame_idx)][static_cast<int>(track)] = s.feature_idx;
      }
    }
  }

  OdometryShard Build() const {
    OdometryShard shard;
    const int end_idx = begin_idx_ + static_cast<int>(frames_.size());
    int last_keyframe = input_.first_frame_idx > begin_idx_ ? input_.first_frame_idx - 1 : -1;
    for (int idx = input_.first_frame_idx; idx < end_idx; ++idx) {
      const ChainedFrame& frame = frames_[At(idx)];
      const bool is_end = idx + 1 == end_idx;
      const bool is_keyframe = last_keyframe < 0 || is_end || NeedsKeyframe(last_keyframe, idx);
      shard.frames.push_back({idx, frame.shard_from_camera, frame.state, is_keyframe});
      if (!is_keyframe) continue;
      if (last_keyframe >= 0) shard.edges.push_back(MakeEdge(last_keyframe, idx));
      last_keyframe = idx;
    }
    shard.tracks = bundle_.tracks;
    return shard;
  }

 private:
  std::size_t At(int frame_idx) const { return static_cast<std::size_t>(frame_idx - begin_idx_); }

  // A bridged frame is no keyframe, because its pose is a guess; nor is a frame without
  // descriptors. A frame that starts a part is a keyframe, because loops will move the part
  // relative to the frames before it.
  bool NeedsKeyframe(int keyframe, int idx) const {
    if (frames_[At(idx)].state == TrackingState::kBridged) return false;
    if (frames_[At(idx)].state == TrackingState::kStarted) return true;
    if (!input_.features.frames[At(idx)].IsDescribed()) return false;
    const Rigid3 relative =
        frames_[At(keyframe)].shard_from_camera.Inverse() * frames_[At(idx)].shard_from_camera;
    return relative.translation.norm() > options_.keyframe_distance_m ||
           AngleBetween_rad(relative, Rigid3()) > options_.keyframe_angle_rad ||
           Overlap(keyframe, idx) < kKeyframeMinOverlap;
  }

  // Share of the keyframe's tracks that the frame still sees.
  double Overlap(int keyframe, int idx) const {
    const auto& reference = tracks_[At(keyframe)];
    int num_shared = 0;
    for (const auto& [track, feature] : reference) num_shared += tracks_[At(idx)].contains(track);
    return reference.empty()
               ? 0
               : static_cast<double>(num_shared) / static_cast<double>(reference.size());
  }

  PoseEdge MakeEdge(int a, int b) const {
    const Rigid3 b_from_shard = frames_[At(b)].shard_from_camera.Inverse();
    PoseEdge edge{a, b, b_from_shard * frames_[At(a)].shard_from_camera, {}, false};
    std::optional<Matrix6d> covariance;
    if (!IsBroken(a, b)) covariance = EdgeCovariance(a, b, edge.b_from_a);
    edge.is_bridge = !covariance;
    edge.covariance = covariance ? *covariance : BridgeCovariance(a, b);
    return edge;
  }

  // True when no measurement may connect a and b. Tracks across the gap disprove that.
  bool IsBroken(int a, int b) const {
    bool has_gap = false;
    for (int idx = a + 1; idx <= b; ++idx) {
      has_gap = has_gap || frames_[At(idx)].state != TrackingState::kTracked;
    }
    return has_gap && SharedPoints(a, b).size() < 10;
  }

  // Points of the tracks that both frames see, with the pixels in b.
  std::vector<PointMatch> SharedPoints(int a, int b) const {
    const Rigid3 a_from_shard = frames_[At(a)].shard_from_camera.Inverse();
    const FrameFeatures& features = input_.features.frames[At(b)];
    std::vector<PointMatch> matches;
    for (const auto& [track, feature] : tracks_[At(a)]) {
      const auto found = tracks_[At(b)].find(track);
      if (found == tracks_[At(b)].end()) continue;
      const FeatureView seen = features.Feature(found->second);
      matches.push_back({seen.Pixel(),
                         a_from_shard * bundle_.points_in_shard[static_cast<std::size_t>(track)],
                         seen.Depth_m(),
                         0});
    }
    return matches;
  }

  // From the points that both see; where they share few, the sum over the frames between.
  std::optional<Matrix6d> EdgeCovariance(int a, int b, const Rigid3& b_from_a) const {
    const RgbdCamera& camera =
        input_.cameras.at(static_cast<std::size_t>(input_.frames[At(b)].camera_idx));
    AbsolutePoseOptions pose_options;
    pose_options.noise = camera.noise;
    pose_options.pixel_sigma_px = options_.pixel_sigma_px;
    const auto matches = SharedPoints(a, b);
    if (matches.size() >= 10) return PoseCovariance(camera.color, matches, b_from_a, pose_options);
    if (b - a <= 1) return std::nullopt;
    const int middle = (a + b) / 2;
    const auto first = EdgeCovariance(a, middle, Relative(middle, a));
    const auto second = EdgeCovariance(middle, b, Relative(b, middle));
    if (!first || !second) return std::nullopt;
    return *first + *second;
  }

  Rigid3 Relative(int target, int source) const {
    return frames_[At(target)].shard_from_camera.Inverse() * frames_[At(source)].shard_from_camera;
  }

  // The camera may have moved farther the longer it was not tracked. Another recording may begin
  // anywhere.
  Matrix6d BridgeCovariance(int a, int b) const {
    const FrameRecord& frame_a = input_.frames[At(a)];
    const FrameRecord& frame_b = input_.frames[At(b)];
    const double gap_s = frame_a.sequence_idx == frame_b.sequence_idx
                             ? 1e-9 * static_cast<double>(frame_b.time_ns - frame_a.time_ns)
                             : std::numeric_limits<double>::infinity();
    const double sigma_rad = std::min(kAnywhereSigma_rad, gap_s * kBridge_rad_per_s);
    const double sigma_m = std::min(kAnywhereSigma_m, gap_s * kBridge_m_per_s);
    Matrix6d covariance = Matrix6d::Zero();
    covariance.diagonal().head<3>().setConstant(sigma_rad * sigma_rad);
    covariance.diagonal().tail<3>().setConstant(sigma_m * sigma_m);
    return covariance;
  }

  const OdometryOptions& options_;
  const OdometryInput& input_;
  const std::vector<ChainedFrame>& frames_;
  const ShardBundle& bundle_;
  int begin_idx_;
  TracksOfFrames tracks_;
};

void CheckInput(const OdometryInput& input) {
  CheckFeaturesOfFrames(input.frames, input.features);
  const int end_idx = input.frames.front().frame_idx + static_cast<int>(input.frames.size());
  for (const FramePair& pair : input.pairs) {
    if (pair.frame_a < input.frames.front().frame_idx || pair.frame_b >= end_idx) {
      throw InputError(
          {{"pairs"}}, "pair {}-{} is outside the given frames", pair.frame_a, pair.frame_b);
    }
  }
  // A frame's pairs are found by binary search.
  if (!std::ranges::is_sorted(input.pairs, {}, &FramePair::frame_b)) {
    throw InputError({{"pairs"}}, "the pairs are not sorted by their second frame");
  }
}

}  // namespace

OdometryResult RunOdometry(const OdometryOptions& options,
                           const OdometryInput& input,
                           Progress& progress) {
  CheckInput(input);
  progress.Start(3);
  std::vector<ChainedFrame> frames = ChainPoses(input.pairs,
                                                input.frames.front().frame_idx,
                                                input.first_frame_idx,
                                                static_cast<int>(input.frames.size()));
  progress.Advance();
  const ShardBundle bundle = AdjustShard(options, input, &frames);
  progress.Advance();
  return {KeyframeGraph(options, input, frames, bundle).Build(),
          bundle.adjustments,
          bundle.num_unrefined};
}

}  // namespace nightmap
