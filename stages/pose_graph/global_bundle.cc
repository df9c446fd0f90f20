// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/global_bundle.h"

#include <algorithm>
#include <cmath>

#include "pipeline/geometry/bundle_adjustment.h"

namespace nightmap {
namespace {

class KeyframeAdjuster {
 public:
  KeyframeAdjuster(const PoseGraphOptions& options,
                   const PoseGraphInput& input,
                   std::map<int, Rigid3>* graph_from_keyframe)
      : options_(options), input_(input), poses_(*graph_from_keyframe) {
    problem_.depth_scales.assign(input.cameras.size(), 1.0);
    for (const auto& [frame_idx, pose] : poses_) {
      position_[frame_idx] = static_cast<int>(problem_.camera_from_world.size());
      problem_.camera_from_world.push_back(pose.Inverse());
      problem_.cameras.push_back(CameraOf(frame_idx).color);
      problem_.depth_scale_idx.push_back(CameraIdx(frame_idx));
      problem_.is_fixed.push_back(problem_.is_fixed.empty());
    }
  }

  GlobalBundleSummary Run(std::vector<Track> tracks) {
    for (const Track& track : SelectLongest(std::move(tracks))) AddTrack(track);
    BundleOptions bundle_options;
    bundle_options.max_iterations = options_.bundle_iterations;
    bundle_options.estimate_depth_scales = options_.estimate_depth_scales;
    for (int round = 0; round < 2; ++round) {
      if (problem_.observations.empty()) break;
      AdjustBundle(bundle_options, &problem_);
      DropOutliers();
    }
    for (auto& [frame_idx, pose] : poses_) {
      pose = problem_.camera_from_world[static_cast<std::size_t>(position_[frame_idx])].Inverse();
    }
    return {Rms_px(), static_cast<int>(problem_.observations.size()), problem_.depth_scales};
  }

 private:
  int CameraIdx(int frame_idx) const {
    return input_.frames[static_cast<std::size_t>(frame_idx)].camera_idx;
  }
  const RgbdCamera& CameraOf(int frame_idx) const {
    return input_.cameras.at(static_cast<std::size_t>(CameraIdx(frame_idx)));
  }
  double Depth_m(const Sighting& s) const {
    return input_.features.frames[static_cast<std::size_t>(s.first)].depths_m.at(
        static_cast<std::size_t>(s.second));
  }
  Eigen::Vector2d Pixel(const Sighting& s) const {
    return input_.features.frames[static_cast<std::size_t>(s.first)]
        .keypoints_px.at(static_cast<std::size_t>(s.second))
        .cast<double>();
  }

  std::vector<Track> SelectLongest(std::vector<Track> tracks) const {
    std::ranges::stable_sort(tracks, std::greater<>(), &Track::size);
    std::map<int, int> count;
    std::vector<Track> chosen;
    for (Track& track : tracks) {
      const bool has_depth = std::ranges::any_of(track, [&](auto& s) { return Depth_m(s) > 0; });
      const bool is_wanted = std::ranges::any_of(
          track, [&](auto& s) { return count[s.first] < options_.max_tracks_per_keyframe; });
      if (!has_depth || !is_wanted) continue;
      for (const Sighting& s : track) ++count[s.first];
      chosen.push_back(std::move(track));
    }
    return chosen;
  }

  void AddTrack(const Track& track) {
    const Sighting* nearest = nullptr;
    for (const Sighting& s : track) {
      if (Depth_m(s) > 0 && (!nearest || Depth_m(s) < Depth_m(*nearest))) nearest = &s;
    }
    const int point_idx = static_cast<int>(problem_.points_in_world.size());
    problem_.points_in_world.push_back(
        poses_.at(nearest->first) *
        CameraOf(nearest->first).color.BackProjectUndistorted(Pixel(*nearest), Depth_m(*nearest)));
    for (const Sighting& s : track) {
      problem_.observations.push_back(
          {position_.at(s.first), point_idx, Pixel(s), Depth_m(s), CameraOf(s.first).noise});
    }
  }

  double Error_px(const BundleObservation& o) const {
    const auto pose = static_cast<std::size_t>(o.pose_idx);
    const auto projected = problem_.cameras[pose].ProjectUndistorted(
        problem_.camera_from_world[pose] *
        problem_.points_in_world[static_cast<std::size_t>(o.point_idx)]);
    return projected ? (*projected - o.pixel).norm() : 1e9;
  }

  void DropOutliers() {
    std::erase_if(problem_.observations, [&](const BundleObservation& o) {
      return Error_px(o) > options_.bundle_max_error_px;
    });
  }

  double Rms_px() const {
    double sum = 0;
    for (const BundleObservation& o : problem_.observations) sum += Error_px(o) * Error_px(o);
    return std::sqrt(sum / std::max<double>(1, static_cast<double>(problem_.observations.size())));
  }

  const PoseGraphOptions& options_;
  const PoseGraphInput& input_;
  std::map<int, Rigid3>& poses_;
  std::map<int, int> position_;  // of a keyframe in the problem
  BundleProblem problem_;
};

}  // namespace

GlobalBundleSummary AdjustKeyframes(const PoseGraphOptions& options,
                                    const PoseGraphInput& input,
                                    std::vector<Track> tracks,
                                    std::map<int, Rigid3>* graph_from_keyframe) {
  return KeyframeAdjuster(options, input, graph_from_keyframe).Run(std::move(tracks));
}

}  // namespace nightmap
