// SPDX-License-Identifier: Apache-2.0
// odometry/shard_NNNN.h5: poses of a shard's frames in the shard's own frame of reference, its
// keyframes, the edges between them, and its feature tracks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/features_io.h"

namespace nightmap {

enum class TrackingState : std::uint8_t {
  kTracked = 0,
  kBridged = 1,  // no verified pair to any frame: pose by interpolation or constant velocity
  kStarted = 2,  // verified pairs only to later frames: a new part begins here
};

struct OdometryFrame {
  int frame_idx = 0;
  Rigid3 shard_from_camera;
  TrackingState state = TrackingState::kTracked;
  bool is_keyframe = false;
};

// Relative pose of two keyframes a < b with the covariance of a left perturbation of b_from_a.
struct PoseEdge {
  int frame_a = 0;
  int frame_b = 0;
  Rigid3 b_from_a;
  Matrix6d covariance = Matrix6d::Identity();
  bool is_bridge = false;  // only a guess joins the two sides: weight it loosely
};

// Sigmas of a bridge between recordings: another one may begin anywhere on a site. A limit of
// several sigmas must not refuse a true loop between the ends of the largest.
inline constexpr double kAnywhereSigma_rad = 3;
inline constexpr double kAnywhereSigma_m = 1000;

// `frames` are the shard's own. Frames of the previous shard appear only in the first edge and in
// the tracks; their poses belong to their own shard. The last own frame is always a keyframe, so
// that the next shard's first edge has both ends.
struct OdometryShard {
  std::vector<OdometryFrame> frames;
  std::vector<PoseEdge> edges;
  std::vector<Track> tracks;  // in a file each has at least one sighting
};

// All throw DataError naming file and field.
void WriteOdometry(const std::filesystem::path& path,
                   const OdometryShard& shard,
                   const std::string& config);
OdometryShard ReadOdometry(const std::filesystem::path& path);
// Does not read the tracks, which are most of the file.
OdometryShard ReadOdometryWithoutTracks(const std::filesystem::path& path);

}  // namespace nightmap
