// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/global_bundle.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

#include "pipeline/base/union_find.h"
#include "pipeline/geometry/bundle_adjustment.h"

namespace nightmap {
namespace {

using Sighting = std::pair<int, int>;  // frame, feature
using Track = std::vector<Sighting>;   // ascending frame

std::uint64_t Key(int frame_idx, int feature_idx) {
  return (static_cast<std::uint64_t>(frame_idx) << 32) | static_cast<std::uint32_t>(feature_idx);
}

// Tracks over all shards, joined by shared features and by loops.
class TrackMerger {
 public:
  explicit TrackMerger(const std::vector<OdometryShard>& shards) : sets_(CountTracks(shards)) {
    std::size_t first_track = 0;
    for (const OdometryShard& shard : shards) {
      std::size_t num_tracks = 0;
      for (const TrackObservation& o : shard.observations) {
        const std::size_t track = first_track + static_cast<std::size_t>(o.track_idx);
        num_tracks = std::max(num_tracks, static_cast<std::size_t>(o.track_idx) + 1);
        const auto [found, is_new] = track_of_.emplace(Key(o.frame_idx, o.feature_idx), track);
        if (is_new) sightings_.push_back({o.frame_idx, o.feature_idx});
        if (!is_new) sets_.Join(found->second, track);
      }
      first_track += num_tracks;
    }
  }

  void Join(const FramePair& loop) {
    for (const FeatureMatch& match : loop.inliers) {
      const auto a = track_of_.find(Key(loop.frame_a, match.a));
      const auto b = track_of_.find(Key(loop.frame_b, match.b));
      if (a != track_of_.end() && b != track_of_.end()) sets_.Join(a->second, b->second);
    }
  }

  // Sightings in keyframes only; one per keyframe.
  std::vector<Track> KeyframeTracks(const std::map<int, Rigid3>& keyframes) {
    std::map<std::size_t, Track> tracks;
    for (const Sighting& sighting : sightings_) {
      if (!keyframes.contains(sighting.first)) continue;
      tracks[sets_.Find(track_of_.at(Key(sighting.first, sighting.second)))].push_back(sighting);
    }
    std::vector<Track> result;
    for (auto& [root, track] : tracks) {
      std::ranges::sort(track);
      const auto same_frame = [](const Sighting& a, const Sighting& b) {
        return a.first == b.first;
      };
      track.erase(std::unique(track.begin(), track.end(), same_frame), track.end());
      if (track.size() >= 2) result.push_back(std::move(track));
    }
    return result;
  }

 private:
  static std::size_t CountTracks(const std::vector<OdometryShard>& shards) {
    std::size_t count = 0;
    for (const OdometryShard& shard : shards) {
      int last = -1;
      for (const TrackObservation& o : shard.observations) last = std::max(last, o.track_idx);
      count += static_cast<std::size_t>(last + 1);
    }
    return count;
  }

  UnionFind sets_;
  std::unordered_map<std::uint64_t, std::size_t> track_of_;
  std::vector<Sighting> sightings_;
};

class KeyframeAdjuster {
 public:
  KeyframeAdjuster(const PoseGraphOptions& options,
                   const PoseGraphInput& input,
                   std::map<int, Rigid3>* graph_from_keyframe)
      : options_(options), input_(input), poses_(*graph_from_keyframe) {
    for (const auto& [frame_idx, pose] : poses_) {
      position_[frame_idx] = static_cast<int>(problem_.camera_from_world.size());
      problem_.camera_from_world.push_back(pose.Inverse());
      problem_.cameras.push_back(CameraOf(frame_idx).color);
      problem_.is_fixed.push_back(problem_.is_fixed.empty());
    }
  }

  GlobalBundleSummary Run(std::vector<Track> tracks) {
    for (const Track& track : SelectLongest(std::move(tracks))) AddTrack(track);
    BundleOptions bundle_options;
    bundle_options.max_iterations = options_.bundle_iterations;
    for (int round = 0; round < 2; ++round) {
      if (problem_.observations.empty()) break;
      AdjustBundle(bundle_options, &problem_);
      DropOutliers();
    }
    for (auto& [frame_idx, pose] : poses_) {
      pose = problem_.camera_from_world[static_cast<std::size_t>(position_[frame_idx])].Inverse();
    }
    return {Rms_px(), static_cast<int>(problem_.observations.size())};
  }

 private:
  const RgbdCamera& CameraOf(int frame_idx) const {
    const FrameRecord& frame = input_.frames[static_cast<std::size_t>(frame_idx)];
    return input_.cameras.at(static_cast<std::size_t>(frame.camera_idx));
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
                                    const std::vector<bool>& is_accepted,
                                    std::map<int, Rigid3>* graph_from_keyframe) {
  TrackMerger merger(input.odometry);
  for (std::size_t i = 0; i < input.loops.size(); ++i) {
    if (is_accepted[i]) merger.Join(input.loops[i]);
  }
  auto tracks = merger.KeyframeTracks(*graph_from_keyframe);
  return KeyframeAdjuster(options, input, graph_from_keyframe).Run(std::move(tracks));
}

}  // namespace nightmap
