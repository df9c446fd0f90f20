// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_tracks/corner_tracker.h"

#include <algorithm>
#include <utility>

#include "pipeline/base/median.h"

namespace nightmap {
namespace {

// Two tracks nearer than this follow one corner.
constexpr float kSameCorner_px = 3;

Eigen::Vector2f MedianOf(const std::vector<Eigen::Vector2f>& steps_px) {
  if (steps_px.empty()) return Eigen::Vector2f::Zero();
  std::vector<float> x, y;
  for (const Eigen::Vector2f& step : steps_px) {
    x.push_back(step.x());
    y.push_back(step.y());
  }
  return {Median(std::move(x)), Median(std::move(y))};
}

Eigen::Vector2f Undistorted(const Camera& camera, const Eigen::Vector2f& raw_px) {
  return camera.Undistort(raw_px.cast<double>()).cast<float>();
}

}  // namespace

void CornerTracker::Add(const FrameRecord& frame,
                        const Camera& camera,
                        const FrameFeatures& features,
                        std::optional<FlowPyramid> picture) {
  TrackedFrame tracked;
  tracked.time_ns = frame.time_ns;
  tracked.frame_idx = frame.frame_idx;
  const bool goes_on = picture && last_picture_ && frame.camera_idx == camera_idx_ &&
                       frame.sequence_idx == sequence_idx_;
  if (goes_on) {
    Follow(camera, *picture, &tracked);
  } else {
    num_ended_[static_cast<std::size_t>(TrackEnd::kNewPicture)] += static_cast<int>(alive_.size());
    alive_.clear();
    median_step_px_.setZero();
  }
  if (picture) Begin(camera, features, &tracked);
  for (const Track& track : alive_) {
    tracked.sightings.push_back({track.id, track.raw_px, track.px});
  }
  tracks_.frames.push_back(std::move(tracked));
  last_picture_ = std::move(picture);
  camera_idx_ = frame.camera_idx;
  sequence_idx_ = frame.sequence_idx;
}

void CornerTracker::Follow(const Camera& camera,
                           const FlowPyramid& picture,
                           TrackedFrame* tracked) {
  std::vector<Eigen::Vector2f> pixels, steps_px;
  for (const Track& track : alive_) {
    pixels.push_back(track.raw_px);
    steps_px.push_back(track.step_px);
  }
  const auto followed = FollowCorners(*last_picture_, picture, pixels, steps_px, flow_);
  std::vector<Track> kept;
  std::vector<Eigen::Vector2f> raw_steps_px, displacements_px;
  for (std::size_t i = 0; i < alive_.size(); ++i) {
    const Eigen::Vector2f& raw_px = followed[i].pixel;
    if (followed[i].end) {
      End(*followed[i].end);
    } else if (!camera.Sees(raw_px.cast<double>())) {
      End(TrackEnd::kBorder);
    } else if (std::ranges::any_of(kept, [&](const Track& older) {
                 return (older.raw_px - raw_px).norm() < kSameCorner_px;
               })) {
      End(TrackEnd::kMerged);
    } else {
      const Eigen::Vector2f step_px = raw_px - alive_[i].raw_px;
      kept.push_back({alive_[i].id, raw_px, Undistorted(camera, raw_px), step_px});
      raw_steps_px.push_back(step_px);
      displacements_px.push_back(kept.back().px - alive_[i].px);
    }
  }
  alive_ = std::move(kept);
  median_step_px_ = MedianOf(raw_steps_px);
  tracked->median_displacement_px = MedianOf(displacements_px);
}

void CornerTracker::Begin(const Camera& camera,
                          const FrameFeatures& features,
                          TrackedFrame* tracked) {
  if (!features.IsDescribed()) return;
  std::vector<Eigen::Vector2f> pixels;
  for (const Track& track : alive_) pixels.push_back(track.raw_px);
  const auto chosen = ChooseNewCorners(features.raw_keypoints_px, pixels, camera, new_corners_);
  tracked->is_redetected =
      !chosen.empty() && static_cast<int>(alive_.size()) < new_corners_.min_tracks;
  for (const int i : chosen) {
    const auto at = static_cast<std::size_t>(i);
    const std::int64_t id = MakeTrackId(tracked->frame_idx, i);
    alive_.push_back({id,
                      features.raw_keypoints_px[at],
                      features.keypoints_px[at],
                      median_step_px_});  // of the others, to look for it in the next picture
    TrackDescriptor& descriptor = tracks_.descriptors.emplace_back();
    descriptor.track_id = id;
    std::copy_n(features.Feature(i).Descriptor(DescriptorKind::kOrb), 32, descriptor.orb.begin());
  }
}

}  // namespace nightmap
