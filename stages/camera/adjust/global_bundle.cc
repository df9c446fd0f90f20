// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/global_bundle.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "pipeline/base/memory.h"
#include "pipeline/geometry/bundle_adjustment.h"
#include "stages/camera/adjust/visit_by_frame.h"

namespace nightmap {
namespace {

constexpr double kBundleMaxError_px = 4.0;  // observations with a larger error are dropped
constexpr int kMaxTracksPerKeyframe = 250;  // longest tracks per frame that enter bundle adjustment

class FrameAdjuster {
 public:
  FrameAdjuster(const AdjustInput& input,
                const std::map<int, PointMotion>& motions,
                std::map<int, Rigid3>* graph_from_frame)
      : input_(input), poses_(*graph_from_frame) {
    problem_.calibrations.assign(input.cameras.size(), {});
    for (const auto& [frame_idx, pose] : poses_) {
      position_[frame_idx] = static_cast<int>(problem_.camera_from_world.size());
      problem_.camera_from_world.push_back(pose.Inverse());
      problem_.cameras.push_back(CameraOf(frame_idx).color);
      problem_.sensor_idx.push_back(CameraIdx(frame_idx));
      if (!motions.empty()) problem_.motions.push_back(motions.at(frame_idx));
      problem_.is_fixed.push_back(problem_.is_fixed.empty());
    }
  }

  GlobalBundleSummary Run(const BundleOptions& bundle_options, TrackList tracks) {
    AddTracks(SelectLongest(std::move(tracks)));
    input_.features.Release();
    ReturnFreeMemory();
    std::vector<BundleSummary> adjustments;
    for (int round = 0; round < 2; ++round) {
      if (problem_.observations.empty()) break;
      adjustments.push_back(AdjustBundle(bundle_options, &problem_));
      DropOutliers();
    }
    for (auto& [frame_idx, pose] : poses_) {
      pose = problem_.camera_from_world[static_cast<std::size_t>(position_[frame_idx])].Inverse();
    }
    GlobalBundleSummary summary{Rms_px(),
                                static_cast<int>(problem_.observations.size()),
                                problem_.calibrations,
                                std::move(adjustments),
                                {}};
    if (bundle_options.calibrate) {
      summary.depth_offsets = EstimateDepthOffsets(bundle_options, std::move(problem_));
    }
    return summary;
  }

 private:
  int CameraIdx(int frame_idx) const {
    return input_.frames[static_cast<std::size_t>(frame_idx)].camera_idx;
  }
  const RgbdCamera& CameraOf(int frame_idx) const {
    return input_.cameras.at(static_cast<std::size_t>(CameraIdx(frame_idx)));
  }
  // A keypoint of a large patch is localized less precisely.
  static double PixelSigma_px(const FeatureView& feature) {
    constexpr double kOfSmallest_px = 0.5;
    constexpr double kPerDiameter = 0.1;
    return std::hypot(kOfSmallest_px, kPerDiameter * feature.Scale_px());
  }

  TrackList SelectLongest(TrackList tracks) const {
    std::vector<std::uint32_t> order = WithDepth(tracks);
    std::ranges::stable_sort(
        order, std::greater<>(), [&](std::uint32_t i) { return tracks[i].size(); });
    std::map<int, int> count;
    TrackList chosen;
    for (const std::uint32_t i : order) {
      const bool is_wanted = std::ranges::any_of(
          tracks[i], [&](auto& s) { return count[s.frame_idx] < kMaxTracksPerKeyframe; });
      if (!is_wanted) continue;
      for (const Sighting& s : tracks[i]) ++count[s.frame_idx];
      chosen.Add(tracks[i]);
    }
    return chosen;
  }

  // Tracks whose depth was measured.
  std::vector<std::uint32_t> WithDepth(const TrackList& tracks) const {
    std::vector<bool> has_depth(tracks.size(), false);
    VisitByFrame(tracks, input_.features, [&](std::size_t track, std::size_t, const auto& feature) {
      if (feature.Depth_m() > 0) has_depth[track] = true;
    });
    std::vector<std::uint32_t> with_depth;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      if (has_depth[i]) with_depth.push_back(static_cast<std::uint32_t>(i));
    }
    return with_depth;
  }

  void AddTracks(const TrackList& tracks) {
    AddObservations(tracks);
    problem_.points_in_world.reserve(tracks.size());
    for (std::size_t i = 0; i < tracks.size(); ++i) AddPoint(tracks, i);
  }

  // Track by track.
  void AddObservations(const TrackList& tracks) {
    problem_.observations.reserve(tracks.NumSightings());
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      for (const Sighting& s : tracks[i]) {
        BundleObservation& seen = problem_.observations.emplace_back();
        seen.pose_idx = position_.at(s.frame_idx);
        seen.point_idx = static_cast<int>(i);
        seen.noise = CameraOf(s.frame_idx).noise;
      }
    }
    VisitByFrame(
        tracks, input_.features, [&](std::size_t track, std::size_t k, const auto& feature) {
          BundleObservation& seen = problem_.observations[tracks.Begin(track) + k];
          seen.pixel = feature.Pixel();
          seen.depth_m = feature.Depth_m();
          seen.pixel_sigma_px = PixelSigma_px(feature);
        });
  }

  // Starts where the nearest camera that measured its depth sees it.
  void AddPoint(const TrackList& tracks, std::size_t i) {
    const std::span observations(problem_.observations.data() + tracks.Begin(i), tracks[i].size());
    const BundleObservation* nearest = nullptr;
    for (const BundleObservation& o : observations) {
      if (o.depth_m > 0 && (!nearest || o.depth_m < nearest->depth_m)) nearest = &o;
    }
    const int frame_idx =
        tracks[i][static_cast<std::size_t>(nearest - observations.data())].frame_idx;
    problem_.points_in_world.push_back(
        poses_.at(frame_idx) *
        CameraOf(frame_idx).color.BackProjectUndistorted(nearest->pixel, nearest->depth_m));
  }

  void DropOutliers() {
    std::erase_if(problem_.observations, [&](const BundleObservation& o) {
      return ReprojectionError_px(problem_, o) > kBundleMaxError_px;
    });
  }

  double Rms_px() const {
    double sum = 0;
    for (const BundleObservation& o : problem_.observations) {
      const double error_px = ReprojectionError_px(problem_, o);
      sum += error_px * error_px;
    }
    return std::sqrt(sum / std::max<double>(1, static_cast<double>(problem_.observations.size())));
  }

  const AdjustInput& input_;
  std::map<int, Rigid3>& poses_;
  std::map<int, int> position_;  // index of a frame in the problem
  BundleProblem problem_;
};

}  // namespace

GlobalBundleSummary AdjustFrames(const AdjustInput& input,
                                 const BundleOptions& bundle_options,
                                 TrackList tracks,
                                 const std::map<int, PointMotion>& motions,
                                 std::map<int, Rigid3>* graph_from_frame) {
  return FrameAdjuster(input, motions, graph_from_frame).Run(bundle_options, std::move(tracks));
}

}  // namespace nightmap
