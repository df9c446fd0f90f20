// SPDX-License-Identifier: Apache-2.0
// Landmarks under construction: which feature of which posed frame shows which point. Compares each
// frame only with points in the voxels that its own depth falls into, so the work per frame does
// not grow with the map. Deterministic; one thread.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

// One posed frame that observes landmarks.
struct Observer {
  const FrameRecord* frame = nullptr;
  const RgbdCamera* camera = nullptr;
  const FrameFeatures* features = nullptr;
  Rigid3 map_from_camera;
};

// The point of a feature with depth.
Eigen::Vector3d FeatureInMap(const Observer& observer, int feature_idx);

struct LandmarkTrackerOptions {
  double max_error_px = 4.0;     // between a projected point and the feature that observes it
  double max_depth_error = 0.1;  // relative
  // 1 is the distance of unrelated descriptors. A weakly similar feature near the expected position
  // is often a neighbour of the true feature: it would confirm the pose as it is, correct or not.
  double max_descriptor_distance = 0.4;
  double voxel_size_m = 0.25;   // of the index that finds points
  double pixel_sigma_px = 1.0;  // of a keypoint and its pose together
};

// Weighted mean of points that are uncertain in different directions.
class PointEstimate {
 public:
  // Adds a feature seen from `observer`. `z_m` is the depth to assume where none was measured; it
  // then carries no weight along the ray.
  void Add(const Observer& observer, int feature, double z_m, double pixel_sigma_px);
  Eigen::Vector3d Position() const;
  // Standard deviation, root mean square over the axes.
  double Sigma_m() const;

 private:
  Eigen::Matrix3d information_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d weighted_sum_ = Eigen::Vector3d::Zero();
};

struct LandmarkTrack {
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
  PointEstimate estimate;
  Track sightings;  // frame_idx counts the observers
};

class LandmarkTracker {
 public:
  LandmarkTracker(const LandmarkTrackerOptions& options,
                  DescriptorKind kind,
                  const std::vector<Observer>* observers)
      : options_(options), kind_(kind), observers_(observers) {}

  // Observers must be added in order, each once.
  void Add(int observer);
  std::vector<LandmarkTrack> TakeTracks() { return std::move(tracks_); }

 private:
  struct Candidate {
    int distance = 0;
    int feature = 0;
    int track = 0;
  };
  struct Projection {
    int track = 0;
    double z_m = 0;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  };
  std::vector<int> TracksNear(const Observer& observer) const;
  std::vector<Projection> Project(const Observer& observer) const;
  std::vector<Candidate> FindCandidates(const Observer& observer) const;
  bool DepthAgrees(const Observer& observer, int feature, double z_m) const;
  int Distance(const std::uint8_t* descriptor, const LandmarkTrack& track) const;
  void Found(int observer, int feature);

  LandmarkTrackerOptions options_;
  DescriptorKind kind_;
  const std::vector<Observer>* observers_;
  std::vector<LandmarkTrack> tracks_;
  std::unordered_map<std::uint64_t, std::vector<int>> voxels_;  // tracks founded in each voxel
};

}  // namespace nightmap
