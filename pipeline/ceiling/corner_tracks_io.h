// SPDX-License-Identifier: Apache-2.0
// <job>/shard_NNNN.h5: corners followed from picture to picture of an upward camera, for one shard.
//
// A file begins with the last frame of the shard before, so that consecutive files share one frame;
// tracks of different files meet there by their pixels.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace nightmap {

// Unique over the site without a look at other shards: frame_idx of the track's first frame times
// 2^20, plus the index of its corner among the features of that frame. Older tracks have smaller
// ids. In a frame that two files share, the same id is the same corner.
constexpr int kTrackFeatureBits = 20;
constexpr std::int64_t MakeTrackId(int first_frame_idx, int feature_idx) {
  return (std::int64_t{first_frame_idx} << kTrackFeatureBits) + feature_idx;
}
constexpr int FirstFrameOf(std::int64_t track_id) {
  return static_cast<int>(track_id >> kTrackFeatureBits);
}
constexpr int FirstFeatureOf(std::int64_t track_id) {
  return static_cast<int>(track_id & ((1 << kTrackFeatureBits) - 1));
}

struct CornerSighting {
  std::int64_t track_id = 0;
  Eigen::Vector2f raw_px = Eigen::Vector2f::Zero();  // in the image file
  Eigen::Vector2f px = Eigen::Vector2f::Zero();      // undistorted, same fx fy cx cy
};

struct TrackedFrame {
  std::int64_t time_ns = 0;
  int frame_idx = 0;
  std::vector<CornerSighting> sightings;  // ascending track_id
  // Median, along x and along y, of px minus px in the frame before, over the tracks in both; 0
  // without any.
  Eigen::Vector2f median_displacement_px = Eigen::Vector2f::Zero();
  bool is_redetected = false;  // so few tracks were left that corners were taken anew
};

struct TrackDescriptor {
  std::int64_t track_id = 0;
  std::array<std::uint8_t, 32> orb{};  // of the corner in the track's first frame
};

// A track is in every frame from its first to its last: a corner found again is another track.
struct CornerTracks {
  std::vector<TrackedFrame> frames;          // contiguous frame_idx
  std::vector<TrackDescriptor> descriptors;  // one per track, ascending track_id
};

// Equal tracks give equal bytes. Throws DataError.
void WriteCornerTracks(const std::filesystem::path& path,
                       const CornerTracks& tracks,
                       const std::string& config);

// Throws DataError naming file and field on sizes that do not add up, NaN, frames that are not
// contiguous, a time that is there twice, ids that do not ascend, a track that begins in another
// frame than its id says or has a gap, and a track without descriptor or the reverse.
CornerTracks ReadCornerTracks(const std::filesystem::path& path);

}  // namespace nightmap
