// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/odometry/initial_poses.h"

#include <algorithm>
#include <span>

namespace nightmap {
namespace {

class Chain {
 public:
  Chain(const std::vector<FramePair>& pairs, int begin_idx, int first_frame_idx, int num_frames)
      : pairs_(pairs),
        begin_idx_(begin_idx),
        first_frame_idx_(first_frame_idx),
        frames_(static_cast<std::size_t>(num_frames)),
        has_followers_(frames_.size(), false) {}

  std::vector<ChainedFrame> Run() {
    const int origin_idx = std::max(begin_idx_, first_frame_idx_ - 1);
    At(origin_idx).is_posed = true;
    const int end_idx = begin_idx_ + static_cast<int>(frames_.size());
    for (int idx = std::max(first_frame_idx_, origin_idx + 1); idx < end_idx; ++idx) Pose(idx);
    InterpolateBridged();
    return std::move(frames_);
  }

 private:
  ChainedFrame& At(int frame_idx) {
    return frames_[static_cast<std::size_t>(frame_idx - begin_idx_)];
  }

  // The pairs of a frame with earlier ones.
  std::span<const FramePair> PairsOf(int frame_idx) const {
    return {std::ranges::lower_bound(pairs_, frame_idx, {}, &FramePair::frame_b),
            std::ranges::upper_bound(pairs_, frame_idx, {}, &FramePair::frame_b)};
  }

  // Prefers tracked partners over bridged ones, then most inliers.
  const FramePair* BestPair(int frame_idx) {
    const FramePair* best = nullptr;
    const auto rank = [&](const FramePair& pair) {
      const bool is_tracked = At(pair.frame_a).state == TrackingState::kTracked;
      return std::pair(is_tracked, pair.inliers.size());
    };
    for (const FramePair& pair : PairsOf(frame_idx)) {
      if (pair.status != PairStatus::kAccepted || !At(pair.frame_a).is_posed) continue;
      if (!best || rank(pair) > rank(*best)) best = &pair;
    }
    return best;
  }

  void Pose(int frame_idx) {
    ChainedFrame& frame = At(frame_idx);
    const FramePair* pair = BestPair(frame_idx);
    frame.is_posed = true;
    if (!pair) {
      frame.state = TrackingState::kBridged;
      frame.shard_from_camera = Extrapolate(frame_idx);
      return;
    }
    frame.shard_from_camera = At(pair->frame_a).shard_from_camera * pair->b_from_a.Inverse();
    has_followers_[static_cast<std::size_t>(pair->frame_a - begin_idx_)] = true;
    PoseEarlierPartners(frame_idx);
  }

  // Poses frames of the previous shard that only pairs of the own shard connect.
  void PoseEarlierPartners(int frame_idx) {
    for (const FramePair& pair : PairsOf(frame_idx)) {
      ChainedFrame& partner = At(pair.frame_a);
      if (pair.status != PairStatus::kAccepted || partner.is_posed) continue;
      partner.shard_from_camera = At(frame_idx).shard_from_camera * pair.b_from_a;
      partner.is_posed = true;
    }
  }

  // Extrapolates at constant velocity over one frame.
  Rigid3 Extrapolate(int frame_idx) {
    const Rigid3& last = At(frame_idx - 1).shard_from_camera;
    if (frame_idx - 2 < begin_idx_ || !At(frame_idx - 2).is_posed) return last;
    return last * (At(frame_idx - 2).shard_from_camera.Inverse() * last);
  }

  // Interpolates a bridged frame on which no later frame depends, which is better than
  // extrapolation; one with followers starts a new part.
  void InterpolateBridged() {
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (frames_[i].state == TrackingState::kBridged && has_followers_[i]) {
        frames_[i].state = TrackingState::kStarted;
      }
    }
    for (std::size_t i = 1; i < frames_.size(); ++i) {
      if (frames_[i].state != TrackingState::kBridged) continue;
      std::size_t next = i + 1;
      while (next < frames_.size() && frames_[next].state == TrackingState::kBridged) ++next;
      if (next == frames_.size() || frames_[next].state == TrackingState::kStarted) continue;
      const double fraction = 1.0 / static_cast<double>(next - i + 1);
      frames_[i].shard_from_camera =
          Interpolate(frames_[i - 1].shard_from_camera, frames_[next].shard_from_camera, fraction);
    }
  }

  const std::vector<FramePair>& pairs_;
  int begin_idx_;
  int first_frame_idx_;
  std::vector<ChainedFrame> frames_;
  std::vector<bool> has_followers_;
};

}  // namespace

std::vector<ChainedFrame> ChainPoses(const std::vector<FramePair>& pairs,
                                     int begin_idx,
                                     int first_frame_idx,
                                     int num_frames) {
  return Chain(pairs, begin_idx, first_frame_idx, num_frames).Run();
}

Rigid3 Interpolate(const Rigid3& a, const Rigid3& b, double fraction) {
  return {a.rotation.slerp(fraction, b.rotation),
          (1 - fraction) * a.translation + fraction * b.translation};
}

}  // namespace nightmap
