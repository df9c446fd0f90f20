// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/global_bundle.h"

#include <algorithm>
#include <cmath>

#include "pipeline/geometry/bundle_adjustment.h"

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

  GlobalBundleSummary Run(const BundleOptions& bundle_options, std::vector<Track> tracks) {
    for (const Track& track : SelectLongest(std::move(tracks))) AddTrack(track);
    std::vector<BundleSummary> adjustments;
    for (int round = 0; round < 2; ++round) {
      if (problem_.observations.empty()) break;
      adjustments.push_back(AdjustBundle(bundle_options, &problem_));
      DropOutliers();
    }
    for (auto& [frame_idx, pose] : poses_) {
      pose = problem_.camera_from_world[static_cast<std::size_t>(position_[frame_idx])].Inverse();
    }
    return {
        Rms_px(),
        static_cast<int>(problem_.observations.size()),
        problem_.calibrations,
        std::move(adjustments),
        bundle_options.calibrate ? EstimateDepthOffsets(bundle_options, problem_) : DepthOffsets{}};
  }

 private:
  int CameraIdx(int frame_idx) const {
    return input_.frames[static_cast<std::size_t>(frame_idx)].camera_idx;
  }
  const RgbdCamera& CameraOf(int frame_idx) const {
    return input_.cameras.at(static_cast<std::size_t>(CameraIdx(frame_idx)));
  }
  FeatureView Feature(const Sighting& s) const {
    return input_.features.frames[static_cast<std::size_t>(s.frame_idx)].Feature(s.feature_idx);
  }

  // A keypoint of a large patch is localized less precisely.
  double PixelSigma_px(const Sighting& s) const {
    constexpr double kOfSmallest_px = 0.5;
    constexpr double kPerDiameter = 0.1;
    return std::hypot(kOfSmallest_px, kPerDiameter * Feature(s).Scale_px());
  }

  std::vector<Track> SelectLongest(std::vector<Track> tracks) const {
    std::ranges::stable_sort(tracks, std::greater<>(), &Track::size);
    std::map<int, int> count;
    std::vector<Track> chosen;
    for (Track& track : tracks) {
      const bool has_depth =
          std::ranges::any_of(track, [&](auto& s) { return Feature(s).Depth_m() > 0; });
      const bool is_wanted = std::ranges::any_of(
          track, [&](auto& s) { return count[s.frame_idx] < kMaxTracksPerKeyframe; });
      if (!has_depth || !is_wanted) continue;
      for (const Sighting& s : track) ++count[s.frame_idx];
      chosen.push_back(std::move(track));
    }
    return chosen;
  }

  void AddTrack(const Track& track) {
    const Sighting* nearest = nullptr;
    for (const Sighting& s : track) {
      if (Feature(s).Depth_m() > 0 &&
          (!nearest || Feature(s).Depth_m() < Feature(*nearest).Depth_m()))
        nearest = &s;
    }
    const int point_idx = static_cast<int>(problem_.points_in_world.size());
    problem_.points_in_world.push_back(
        poses_.at(nearest->frame_idx) *
        CameraOf(nearest->frame_idx)
            .color.BackProjectUndistorted(Feature(*nearest).Pixel(), Feature(*nearest).Depth_m()));
    for (const Sighting& s : track) {
      problem_.observations.push_back({position_.at(s.frame_idx),
                                       point_idx,
                                       Feature(s).Pixel(),
                                       Feature(s).Depth_m(),
                                       CameraOf(s.frame_idx).noise,
                                       PixelSigma_px(s)});
    }
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
                                 std::vector<Track> tracks,
                                 const std::map<int, PointMotion>& motions,
                                 std::map<int, Rigid3>* graph_from_frame) {
  return FrameAdjuster(input, motions, graph_from_frame).Run(bundle_options, std::move(tracks));
}

}  // namespace nightmap
