// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/features/track_features.h"

#include <vector>

#include "pipeline/camera/follow_corners.h"
#include "pipeline/camera/pixel_grid.h"
#include "pipeline/io/masked_pixels.h"

namespace nightmap {
namespace {

// A frame is described anew when a smaller share of the described frame's features is tracked.
constexpr double kMinTrackedRatio = 0.5;
// Largest mean difference of a patch found again, in gray levels.
constexpr double kMaxDifference = 12;
constexpr double kMinDistance_px = 6;

const FlowSearch kSearch{17, 3, 20, 0.01};

// Chooses the strongest features, none near another, because several features of one corner would
// move together. Those with depth come first, because only they can be placed.
std::vector<int> Choose(const FrameFeatures& described, const Camera& camera, int count) {
  PixelGrid grid(camera, kMinDistance_px);
  std::vector<int> chosen;
  for (const bool wants_depth : {true, false}) {
    for (int i = 0; i < described.NumFeatures() && static_cast<int>(chosen.size()) < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      if ((described.depths_m[at] > 0) != wants_depth) continue;
      const Eigen::Vector2d pixel = described.raw_keypoints_px[at].cast<double>();
      bool is_near = false;
      grid.ForNear(pixel, [&](int other) {
        const auto& q = described.raw_keypoints_px[static_cast<std::size_t>(other)];
        is_near = is_near || (q.cast<double>() - pixel).norm() < kMinDistance_px;
      });
      if (is_near) continue;
      grid.Add(pixel, i);
      chosen.push_back(i);
    }
  }
  return chosen;
}

}  // namespace

struct FeatureTracker::State {
  struct Point {
    int feature = 0;  // of the reference
    float scale_px = 0;
    Eigen::Vector2f origin_px;  // in the reference
    Eigen::Vector2f last_px;
    Eigen::Vector2f step_px;  // motion between the last two frames
  };
  FlowPyramid reference;
  int reference_frame_idx = 0;
  int num_frames = 0;  // frames tracked since the reference
  std::size_t num_chosen = 0;
  std::vector<Point> points;  // still tracked

  // The points found again in a picture, outside of the mask.
  std::vector<Point> Find(const ColorImage& color,
                          const Camera& camera,
                          const GrayImage& moving) const {
    std::vector<Eigen::Vector2f> origin_px, predicted_px;
    for (const Point& point : points) {
      origin_px.push_back(point.origin_px);
      predicted_px.push_back(point.last_px + point.step_px);
    }
    const Followed there =
        nightmap::Follow(reference, {ToGray(color), kSearch}, origin_px, kSearch, predicted_px);
    std::vector<Point> found;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector2f& found_px = there.points[i];
      const Eigen::Vector2d raw = found_px.cast<double>();
      if (!there.is_found[i] || !camera.Contains(raw) || there.differences[i] > kMaxDifference ||
          IsMasked(moving, raw)) {
        continue;
      }
      const Point& point = points[i];
      found.push_back(
          {point.feature, point.scale_px, point.origin_px, found_px, found_px - point.last_px});
    }
    return found;
  }

  // Goes on from the points found in a frame.
  FrameFeatures Follow(std::vector<Point> found, const Camera& camera, int frame_idx) {
    FrameFeatures tracked;
    tracked.frame_idx = frame_idx;
    tracked.reference_frame_idx = reference_frame_idx;
    for (const Point& point : found) {
      tracked.reference_features.push_back(point.feature);
      tracked.scales_px.push_back(point.scale_px);
      tracked.raw_keypoints_px.push_back(point.last_px);
      tracked.keypoints_px.push_back(camera.Undistort(point.last_px.cast<double>()).cast<float>());
    }
    tracked.depths_m.assign(found.size(), 0.0f);
    points = std::move(found);
    ++num_frames;
    return tracked;
  }
};

FeatureTracker::FeatureTracker(const TrackingOptions& options) : options_(options) {}
FeatureTracker::FeatureTracker(FeatureTracker&&) noexcept = default;
FeatureTracker::~FeatureTracker() = default;

void FeatureTracker::Start(const ColorImage& color,
                           const Camera& camera,
                           const FrameFeatures& described) {
  if (options_.max_gap_frames == 0) return;
  state_ = std::make_unique<State>();
  state_->reference = FlowPyramid(ToGray(color), kSearch);
  state_->reference_frame_idx = described.frame_idx;
  for (const int i : Choose(described, camera, options_.max_tracked)) {
    const Eigen::Vector2f& pixel = described.raw_keypoints_px[static_cast<std::size_t>(i)];
    const float scale_px = described.scales_px[static_cast<std::size_t>(i)];
    state_->points.push_back({i, scale_px, pixel, pixel, Eigen::Vector2f::Zero()});
  }
  state_->num_chosen = state_->points.size();
}

std::optional<FrameFeatures> FeatureTracker::Track(const ColorImage& color,
                                                   const Camera& camera,
                                                   int frame_idx,
                                                   const GrayImage& moving) {
  if (!state_ || state_->points.empty() || state_->num_frames >= options_.max_gap_frames) {
    return std::nullopt;
  }
  std::vector<State::Point> found = state_->Find(color, camera, moving);
  if (static_cast<double>(found.size()) <
      kMinTrackedRatio * static_cast<double>(state_->num_chosen)) {
    return std::nullopt;
  }
  return state_->Follow(std::move(found), camera, frame_idx);
}

FrameFeatures FeatureTracker::TrackFew(const ColorImage& color,
                                       const Camera& camera,
                                       int frame_idx) {
  FrameFeatures none;
  none.frame_idx = frame_idx;
  if (!state_ || state_->points.empty()) return none;
  return state_->Follow(state_->Find(color, camera, {}), camera, frame_idx);
}

}  // namespace nightmap
