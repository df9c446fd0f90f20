// SPDX-License-Identifier: Apache-2.0
#include "stages/odometry/shard_bundle.h"

#include <algorithm>
#include <numeric>

#include "pipeline/geometry/absolute_pose.h"
#include "pipeline/vision/tracks.h"

namespace nightmap {
namespace {

// Everything by position in input.frames.
class Adjuster {
 public:
  Adjuster(const OdometryOptions& options,
           const OdometryInput& input,
           std::vector<ChainedFrame>* frames)
      : options_(options), input_(input), frames_(*frames), begin_idx_(input.frames[0].frame_idx) {}

  ShardBundle Run() {
    result_.observations = SelectTracks(BuildTracks());
    InitializePoints();
    for (int round = 0; round < 2; ++round) {
      Adjust();
      DropOutliers(/*of_described=*/true);
    }
    RefineTracked();
    DropOutliers(/*of_described=*/false);
    return std::move(result_);
  }

 private:
  std::size_t At(int frame_idx) const { return static_cast<std::size_t>(frame_idx - begin_idx_); }
  const RgbdCamera& CameraOf(int frame_idx) const {
    return input_.cameras.at(static_cast<std::size_t>(input_.frames[At(frame_idx)].camera_idx));
  }

  std::vector<TrackObservation> BuildTracks() const {
    std::vector<int> num_features;
    for (const FrameFeatures& frame : input_.features.frames) {
      num_features.push_back(frame.NumFeatures());
    }
    TrackBuilder builder(begin_idx_, num_features);
    for (const FramePair* pair : TrustedFirst()) {
      for (const FeatureMatch& match : pair->inliers) {
        builder.Join(pair->frame_a, match.a, pair->frame_b, match.b);
      }
    }
    return builder.Build();
  }

  // Whether a pair fits the chained poses. Repeated panels make frames match that see different
  // ones; tracks joined by such a pair would tear the adjustment apart.
  bool Agrees(const FramePair& pair) const {
    const Rigid3 chained = frames_[At(pair.frame_b)].shard_from_camera.Inverse() *
                           frames_[At(pair.frame_a)].shard_from_camera;
    const Rigid3 difference = pair.b_from_a.Inverse() * chained;
    return difference.translation.norm() <= options_.max_pair_error_m &&
           AngleBetween_rad(difference, Rigid3()) <= options_.max_pair_error_rad;
  }

  // Accepted pairs, nearest frames first: their matches are the most reliable.
  std::vector<const FramePair*> TrustedFirst() const {
    std::vector<const FramePair*> pairs;
    for (const FramePair& pair : input_.pairs) {
      if (pair.status == PairStatus::kAccepted && Agrees(pair)) pairs.push_back(&pair);
    }
    std::ranges::stable_sort(
        pairs, {}, [](const FramePair* pair) { return pair->frame_b - pair->frame_a; });
    return pairs;
  }

  // The longest tracks of every frame carry most; the rest only costs time. Tracks of unposed
  // frames or without any depth cannot be placed.
  std::vector<TrackObservation> SelectTracks(std::vector<TrackObservation> all) const {
    std::erase_if(all,
                  [&](const TrackObservation& o) { return !frames_[At(o.frame_idx)].is_posed; });
    const auto begins = TrackBegins(all);
    std::vector<std::size_t> order(begins.size() - 1);
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t t) {
      return std::pair(CountDescribed(all, begins[t], begins[t + 1]), begins[t + 1] - begins[t]);
    });
    std::vector<int> count(frames_.size(), 0);
    std::vector<TrackObservation> selected;
    int track_idx = 0;
    for (const std::size_t t : order) {
      const std::vector<TrackObservation> track(
          all.begin() + static_cast<std::ptrdiff_t>(begins[t]),
          all.begin() + static_cast<std::ptrdiff_t>(begins[t + 1]));
      if (track.size() < 2 || !HasDepth(track) || !IsWanted(track, count)) continue;
      for (TrackObservation o : track) {
        o.track_idx = track_idx;
        ++count[At(o.frame_idx)];
        selected.push_back(o);
      }
      ++track_idx;
    }
    return selected;
  }

  bool IsDescribed(const TrackObservation& o) const {
    return input_.features.frames[At(o.frame_idx)].IsDescribed();
  }
  std::ptrdiff_t CountDescribed(const std::vector<TrackObservation>& observations,
                                std::size_t begin,
                                std::size_t end) const {
    return std::count_if(observations.begin() + static_cast<std::ptrdiff_t>(begin),
                         observations.begin() + static_cast<std::ptrdiff_t>(end),
                         [&](const TrackObservation& o) { return IsDescribed(o); });
  }

  static std::vector<std::size_t> TrackBegins(const std::vector<TrackObservation>& all) {
    std::vector<std::size_t> begins;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (i == 0 || all[i].track_idx != all[i - 1].track_idx) begins.push_back(i);
    }
    begins.push_back(all.size());
    return begins;
  }

  double Depth_m(const TrackObservation& o) const {
    return input_.features.frames[At(o.frame_idx)]
        .depths_m[static_cast<std::size_t>(o.feature_idx)];
  }
  Eigen::Vector2d Pixel(const TrackObservation& o) const {
    return input_.features.frames[At(o.frame_idx)]
        .keypoints_px[static_cast<std::size_t>(o.feature_idx)]
        .cast<double>();
  }

  bool HasDepth(const std::vector<TrackObservation>& track) const {
    return std::ranges::any_of(track, [&](const TrackObservation& o) { return Depth_m(o) > 0; });
  }

  bool IsWanted(const std::vector<TrackObservation>& track, const std::vector<int>& count) const {
    return std::ranges::any_of(track, [&](const TrackObservation& o) {
      return count[At(o.frame_idx)] < options_.max_tracks_per_frame;
    });
  }

  // The nearest measurement is the most precise one; a described frame's is preferred, for its pose
  // is adjusted.
  void InitializePoints() {
    const auto begins = TrackBegins(result_.observations);
    for (std::size_t t = 0; t + 1 < begins.size(); ++t) {
      const TrackObservation* best = nullptr;
      const auto rank = [&](const TrackObservation& o) {
        return std::pair(IsDescribed(o), -Depth_m(o));
      };
      for (std::size_t i = begins[t]; i < begins[t + 1]; ++i) {
        const TrackObservation& o = result_.observations[i];
        if (Depth_m(o) > 0 && (!best || rank(o) > rank(*best))) best = &o;
      }
      sources_.push_back(*best);
      is_adjusted_.push_back(CountDescribed(result_.observations, begins[t], begins[t + 1]) >= 2);
      result_.points_in_shard.push_back(PointOf(*best));
    }
  }

  Eigen::Vector3d PointOf(const TrackObservation& o) const {
    return frames_[At(o.frame_idx)].shard_from_camera *
           CameraOf(o.frame_idx).color.BackProjectUndistorted(Pixel(o), Depth_m(o));
  }

  void Adjust() {
    BundleProblem problem;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      problem.camera_from_world.push_back(frames_[i].shard_from_camera.Inverse());
      problem.cameras.push_back(CameraOf(begin_idx_ + static_cast<int>(i)).color);
      problem.is_fixed.push_back(begin_idx_ + static_cast<int>(i) ==
                                 std::max(begin_idx_, input_.first_frame_idx - 1));
    }
    problem.points_in_world = result_.points_in_shard;
    for (const TrackObservation& o : result_.observations) {
      if (!IsDescribed(o) || !is_adjusted_[static_cast<std::size_t>(o.track_idx)]) continue;
      problem.observations.push_back({static_cast<int>(At(o.frame_idx)),
                                      o.track_idx,
                                      Pixel(o),
                                      Depth_m(o),
                                      CameraOf(o.frame_idx).noise,
                                      options_.pixel_sigma_px});
    }
    BundleOptions bundle_options;
    bundle_options.max_iterations = options_.max_iterations;
    result_.adjustments.push_back(AdjustBundle(bundle_options, &problem));
    result_.points_in_shard = problem.points_in_world;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      frames_[i].shard_from_camera = problem.camera_from_world[i].Inverse();
    }
    for (std::size_t t = 0; t < sources_.size(); ++t) {
      if (!is_adjusted_[t]) result_.points_in_shard[t] = PointOf(sources_[t]);
    }
  }

  void RefineTracked() {
    std::vector<std::vector<PointMatch>> matches(frames_.size());
    for (const TrackObservation& o : result_.observations) {
      if (IsDescribed(o)) continue;
      const auto track = static_cast<std::size_t>(o.track_idx);
      const double sigma_m =
          is_adjusted_[track]
              ? 0
              : CameraOf(sources_[track].frame_idx).noise.Sigma_m(Depth_m(sources_[track]));
      matches[At(o.frame_idx)].push_back(
          {Pixel(o), result_.points_in_shard[track], Depth_m(o), sigma_m});
    }
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (matches[i].empty()) continue;
      const RgbdCamera& camera = CameraOf(begin_idx_ + static_cast<int>(i));
      AbsolutePoseOptions pose_options;
      pose_options.max_error_px = options_.max_error_px;
      pose_options.pixel_sigma_px = options_.pixel_sigma_px;
      pose_options.noise = camera.noise;
      const auto refined = RefineAbsolutePose(
          camera.color, matches[i], frames_[i].shard_from_camera.Inverse(), pose_options);
      if (refined) frames_[i].shard_from_camera = refined->camera_from_world.Inverse();
      if (!refined) ++result_.num_unrefined;
    }
  }

  void DropOutliers(bool of_described) {
    std::erase_if(result_.observations, [&](const TrackObservation& o) {
      if (IsDescribed(o) != of_described) return false;
      const Eigen::Vector3d p = frames_[At(o.frame_idx)].shard_from_camera.Inverse() *
                                result_.points_in_shard[static_cast<std::size_t>(o.track_idx)];
      const auto projected = CameraOf(o.frame_idx).color.ProjectUndistorted(p);
      return !projected || (*projected - Pixel(o)).norm() > options_.max_error_px;
    });
  }

  const OdometryOptions& options_;
  const OdometryInput& input_;
  std::vector<ChainedFrame>& frames_;
  int begin_idx_;
  ShardBundle result_;
  std::vector<TrackObservation> sources_;  // of each track: whose depth placed its point first
  std::vector<bool> is_adjusted_;          // of each track: the adjustment moves its point
};

}  // namespace

ShardBundle AdjustShard(const OdometryOptions& options,
                        const OdometryInput& input,
                        std::vector<ChainedFrame>* frames) {
  return Adjuster(options, input, frames).Run();
}

}  // namespace nightmap
