// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/odometry/shard_bundle.h"

#include <algorithm>
#include <functional>

#include "pipeline/geometry/absolute_pose.h"
#include "stages/camera/odometry/tracks.h"

namespace nightmap {
namespace {

// A pair whose rotation differs more from the chained poses is rejected as a false match.
constexpr double kMaxPairError_rad = 0.1;
constexpr int kMaxTracksPerFrame = 300;  // longest tracks per frame that enter bundle adjustment

// All lists are indexed by position in input.frames.
class Adjuster {
 public:
  Adjuster(const OdometryOptions& options,
           const OdometryInput& input,
           std::vector<ChainedFrame>* frames)
      : options_(options), input_(input), frames_(*frames), begin_idx_(input.frames[0].frame_idx) {}

  ShardBundle Run() {
    result_.tracks = SelectTracks(BuildTracks());
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

  std::vector<Track> BuildTracks() const {
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

  // Whether a pair fits the chained poses. Repeated panels cause false matches between frames that
  // see different panels, and tracks joined by such a pair would break the adjustment.
  bool Agrees(const FramePair& pair) const {
    const Rigid3 chained = frames_[At(pair.frame_b)].shard_from_camera.Inverse() *
                           frames_[At(pair.frame_a)].shard_from_camera;
    const Rigid3 difference = pair.b_from_a.Inverse() * chained;
    return difference.translation.norm() <= options_.max_pair_error_m &&
           AngleBetween_rad(difference, Rigid3()) <= kMaxPairError_rad;
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

  // The longest tracks of every frame carry most of the information; the rest only costs time.
  // Tracks of unposed frames or without any depth cannot be placed.
  std::vector<Track> SelectTracks(std::vector<Track> all) const {
    for (Track& track : all) {
      std::erase_if(track, [&](const Sighting& s) { return !frames_[At(s.frame_idx)].is_posed; });
    }
    std::ranges::stable_sort(all, std::greater<>(), [&](const Track& track) {
      return std::pair(CountDescribed(track), track.size());
    });
    std::vector<int> count(frames_.size(), 0);
    std::vector<Track> selected;
    for (Track& track : all) {
      if (track.size() < 2 || !HasDepth(track) || !IsWanted(track, count)) continue;
      for (const Sighting& s : track) ++count[At(s.frame_idx)];
      selected.push_back(std::move(track));
    }
    return selected;
  }

  bool IsDescribed(const Sighting& s) const {
    return input_.features.frames[At(s.frame_idx)].IsDescribed();
  }
  std::ptrdiff_t CountDescribed(const Track& track) const {
    return std::ranges::count_if(track, [&](const Sighting& s) { return IsDescribed(s); });
  }
  FeatureView Feature(const Sighting& s) const {
    return input_.features.frames[At(s.frame_idx)].Feature(s.feature_idx);
  }

  bool HasDepth(const Track& track) const {
    return std::ranges::any_of(track, [&](const Sighting& s) { return Feature(s).Depth_m() > 0; });
  }

  bool IsWanted(const Track& track, const std::vector<int>& count) const {
    return std::ranges::any_of(
        track, [&](const Sighting& s) { return count[At(s.frame_idx)] < kMaxTracksPerFrame; });
  }

  // Uses the nearest measurement, which is the most precise one, but prefers described frames,
  // because their poses are adjusted.
  void InitializePoints() {
    const auto rank = [&](const Sighting& s) {
      return std::pair(IsDescribed(s), -Feature(s).Depth_m());
    };
    for (const Track& track : result_.tracks) {
      const Sighting* best = nullptr;
      for (const Sighting& s : track) {
        if (Feature(s).Depth_m() > 0 && (!best || rank(s) > rank(*best))) best = &s;
      }
      sources_.push_back(*best);
      is_adjusted_.push_back(CountDescribed(track) >= 2);
      result_.points_in_shard.push_back(PointOf(*best));
    }
  }

  Eigen::Vector3d PointOf(const Sighting& s) const {
    const FeatureView feature = Feature(s);
    return frames_[At(s.frame_idx)].shard_from_camera *
           CameraOf(s.frame_idx).color.BackProjectUndistorted(feature.Pixel(), feature.Depth_m());
  }

  BundleProblem Problem() const {
    BundleProblem problem;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const int frame_idx = begin_idx_ + static_cast<int>(i);
      problem.camera_from_world.push_back(frames_[i].shard_from_camera.Inverse());
      problem.cameras.push_back(CameraOf(frame_idx).color);
      problem.is_fixed.push_back(frame_idx == std::max(begin_idx_, input_.first_frame_idx - 1));
    }
    problem.points_in_world = result_.points_in_shard;
    for (std::size_t t = 0; t < result_.tracks.size(); ++t) {
      for (const Sighting& s : result_.tracks[t]) {
        if (!IsDescribed(s) || !is_adjusted_[t]) continue;
        problem.observations.push_back({static_cast<int>(At(s.frame_idx)),
                                        static_cast<int>(t),
                                        Feature(s).Pixel(),
                                        Feature(s).Depth_m(),
                                        CameraOf(s.frame_idx).noise,
                                        options_.pixel_sigma_px});
      }
    }
    return problem;
  }

  void Adjust() {
    BundleProblem problem = Problem();
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

  // Matches of each tracked frame. A point that no adjustment moved is as uncertain as its depth.
  std::vector<std::vector<PointMatch>> TrackedMatches() const {
    std::vector<std::vector<PointMatch>> matches(frames_.size());
    for (std::size_t t = 0; t < result_.tracks.size(); ++t) {
      const Sighting& source = sources_[t];
      const double sigma_m =
          is_adjusted_[t] ? 0 : CameraOf(source.frame_idx).noise.Sigma_m(Feature(source).Depth_m());
      for (const Sighting& s : result_.tracks[t]) {
        if (IsDescribed(s)) continue;
        matches[At(s.frame_idx)].push_back(
            {Feature(s).Pixel(), result_.points_in_shard[t], Feature(s).Depth_m(), sigma_m});
      }
    }
    return matches;
  }

  void RefineTracked() {
    const auto matches = TrackedMatches();
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
    for (std::size_t t = 0; t < result_.tracks.size(); ++t) {
      std::erase_if(result_.tracks[t], [&](const Sighting& s) {
        if (IsDescribed(s) != of_described) return false;
        const Eigen::Vector3d point_in_camera =
            frames_[At(s.frame_idx)].shard_from_camera.Inverse() * result_.points_in_shard[t];
        return ReprojectionError_px(CameraOf(s.frame_idx).color,
                                    point_in_camera,
                                    Feature(s).Pixel()) > options_.max_error_px;
      });
    }
  }

  const OdometryOptions& options_;
  const OdometryInput& input_;
  std::vector<ChainedFrame>& frames_;
  int begin_idx_;
  ShardBundle result_;
  std::vector<Sighting> sources_;  // by track: the sighting whose depth placed the point first
  std::vector<bool> is_adjusted_;  // by track: whether the adjustment moves its point
};

}  // namespace

ShardBundle AdjustShard(const OdometryOptions& options,
                        const OdometryInput& input,
                        std::vector<ChainedFrame>* frames) {
  return Adjuster(options, input, frames).Run();
}

}  // namespace nightmap
