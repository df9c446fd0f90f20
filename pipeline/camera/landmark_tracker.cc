// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/landmark_tracker.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "pipeline/camera/descriptor_distance.h"
#include "pipeline/camera/pixel_grid.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

void SortUnique(std::vector<std::uint64_t>* values) {
  std::sort(values->begin(), values->end());
  values->erase(std::unique(values->begin(), values->end()), values->end());
}

}  // namespace

Eigen::Vector3d FeatureInMap(const Observer& observer, int feature_idx) {
  const FeatureView feature = observer.features->Feature(feature_idx);
  return observer.map_from_camera *
         observer.camera->color.BackProjectUndistorted(feature.Pixel(), feature.Depth_m());
}

std::vector<int> LandmarkTracker::TracksNear(const Observer& observer) const {
  std::vector<std::uint64_t> centres;
  for (int i = 0; i < observer.features->NumFeatures(); ++i) {
    if (observer.features->Feature(i).Depth_m() <= 0) continue;
    centres.push_back(PackVoxel(VoxelOf(FeatureInMap(observer, i), options_.voxel_size_m)));
  }
  SortUnique(&centres);
  std::vector<std::uint64_t> keys;
  for (const std::uint64_t centre : centres) {
    for (int offset = 0; offset < 27; ++offset) {
      keys.push_back(PackVoxel(UnpackVoxel(centre) +
                               VoxelKey(offset / 9 - 1, offset / 3 % 3 - 1, offset % 3 - 1)));
    }
  }
  SortUnique(&keys);
  std::vector<int> tracks;
  for (const std::uint64_t key : keys) {
    const auto voxel = voxels_.find(key);
    if (voxel == voxels_.end()) continue;
    tracks.insert(tracks.end(), voxel->second.begin(), voxel->second.end());
  }
  std::sort(tracks.begin(), tracks.end());
  return tracks;
}

std::vector<LandmarkTracker::Projection> LandmarkTracker::Project(const Observer& observer) const {
  const Camera& camera = observer.camera->color;
  const Rigid3 camera_from_map = observer.map_from_camera.Inverse();
  std::vector<Projection> projections;
  for (const int track : TracksNear(observer)) {
    const Eigen::Vector3d point =
        camera_from_map * tracks_[static_cast<std::size_t>(track)].position_in_map;
    if (point.z() <= 0.01) continue;
    const auto pixel = camera.ProjectUndistorted(point);
    if (pixel && camera.Contains(*pixel)) projections.push_back({track, point.z(), *pixel});
  }
  return projections;
}

bool LandmarkTracker::DepthAgrees(const Observer& observer, int feature, double z_m) const {
  const double depth_m = observer.features->Feature(feature).Depth_m();
  if (depth_m <= 0) return true;
  return std::abs(depth_m - z_m) <= options_.max_depth_error * std::max(depth_m, z_m);
}

// Compares with the last few sightings, because the point looks about as it did then.
int LandmarkTracker::Distance(const std::uint8_t* descriptor, const LandmarkTrack& track) const {
  constexpr std::size_t kNumCompared = 3;
  const std::size_t count = track.sightings.size();
  int best = std::numeric_limits<int>::max();
  for (std::size_t i = count - std::min(count, kNumCompared); i < count; ++i) {
    const Sighting& sighting = track.sightings[i];
    const Observer& observer = (*observers_)[static_cast<std::size_t>(sighting.frame_idx)];
    best = std::min(
        best,
        DescriptorDistance(
            kind_, descriptor, observer.features->Feature(sighting.feature_idx).Descriptor(kind_)));
  }
  return best;
}

std::vector<LandmarkTracker::Candidate> LandmarkTracker::FindCandidates(
    const Observer& observer) const {
  const std::vector<Projection> projections = Project(observer);
  PixelGrid grid(observer.camera->color, options_.max_error_px);
  for (std::size_t i = 0; i < projections.size(); ++i) {
    grid.Add(projections[i].pixel, static_cast<int>(i));
  }
  const int max_distance = DistanceFromRelative(kind_, options_.max_descriptor_distance);
  std::vector<Candidate> candidates;
  for (int feature = 0; feature < observer.features->NumFeatures(); ++feature) {
    const Eigen::Vector2d pixel = observer.features->Feature(feature).Pixel();
    const std::uint8_t* descriptor = observer.features->Feature(feature).Descriptor(kind_);
    grid.ForNear(pixel, [&](int i) {
      const Projection& projection = projections[static_cast<std::size_t>(i)];
      if ((projection.pixel - pixel).norm() > options_.max_error_px) return;
      if (!DepthAgrees(observer, feature, projection.z_m)) return;
      const int distance =
          Distance(descriptor, tracks_[static_cast<std::size_t>(projection.track)]);
      if (distance <= max_distance) candidates.push_back({distance, feature, projection.track});
    });
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.distance, a.feature, a.track) < std::tie(b.distance, b.feature, b.track);
  });
  return candidates;
}

void LandmarkTracker::Found(int observer_idx, int feature) {
  const Observer& observer = (*observers_)[static_cast<std::size_t>(observer_idx)];
  LandmarkTrack track;
  track.position_in_map = FeatureInMap(observer, feature);
  track.sightings.push_back({observer_idx, feature});
  track.estimate.Add(observer, feature, 0.0, options_.pixel_sigma_px);
  const VoxelKey voxel = VoxelOf(track.position_in_map, options_.voxel_size_m);
  voxels_[PackVoxel(voxel)].push_back(static_cast<int>(tracks_.size()));
  tracks_.push_back(std::move(track));
}

void LandmarkTracker::Add(int observer_idx) {
  const Observer& observer = (*observers_)[static_cast<std::size_t>(observer_idx)];
  const int num_features = observer.features->NumFeatures();
  std::vector<bool> used(static_cast<std::size_t>(num_features), false);
  // Most similar first, one to one.
  for (const Candidate& candidate : FindCandidates(observer)) {
    LandmarkTrack& track = tracks_[static_cast<std::size_t>(candidate.track)];
    if (used[static_cast<std::size_t>(candidate.feature)]) continue;
    if (track.sightings.back().frame_idx == observer_idx) continue;
    used[static_cast<std::size_t>(candidate.feature)] = true;
    const double z_m = (observer.map_from_camera.Inverse() * track.position_in_map).z();
    track.estimate.Add(observer, candidate.feature, z_m, options_.pixel_sigma_px);
    track.position_in_map = track.estimate.Position();
    track.sightings.push_back({observer_idx, candidate.feature});
  }
  for (int i = 0; i < num_features; ++i) {
    const bool has_depth = observer.features->Feature(i).Depth_m() > 0;
    if (!used[static_cast<std::size_t>(i)] && has_depth) Found(observer_idx, i);
  }
}

}  // namespace nightmap
