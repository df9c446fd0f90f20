// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/odometry_io.h"

#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kOdometryFormat[] = "nightmap odometry";
constexpr int kOdometryVersion = 1;

constexpr auto kOdometryFrames = Hdf5Table<OdometryFrame>(
    Hdf5Column("frame_idx", &OdometryFrame::frame_idx)
        .Elements(kNotNegative)
        .Pairs([](const OdometryFrame& before, const OdometryFrame& frame) {
          return before.frame_idx == frame.frame_idx - 1;
        }),
    Hdf5Column("state", &OdometryFrame::state).Rows([](const OdometryFrame& frame) {
      return frame.state <= TrackingState::kStarted;
    }),
    Hdf5Column("is_keyframe", &OdometryFrame::is_keyframe),
    Hdf5Column("shard_from_camera", &OdometryFrame::shard_from_camera));

constexpr auto kPoseEdges = Hdf5Table<PoseEdge>(
    Hdf5Column("edge_frame", &PoseEdge::frame_a, &PoseEdge::frame_b).Rows([](const PoseEdge& edge) {
      return edge.frame_a >= 0 && edge.frame_a < edge.frame_b;
    }),
    Hdf5Column("edge_b_from_a", &PoseEdge::b_from_a),
    Hdf5Column("edge_covariance", &PoseEdge::covariance),
    Hdf5Column("edge_is_bridge", &PoseEdge::is_bridge));

// Rows of a track follow each other. A track that lost all its sightings has no row, so its number
// is missing.
struct Observation {
  std::int32_t track = 0;
  Sighting sighting;
};

constexpr auto kObservations = Hdf5Table<Observation>(
    Hdf5Column("observation",
               &Observation::track,
               MemberOf(&Observation::sighting, &Sighting::frame_idx),
               MemberOf(&Observation::sighting, &Sighting::feature_idx))
        .Elements(kNotNegative)
        .Pairs([](const Observation& before, const Observation& row) {
          return before.track < row.track ||
                 (before.track == row.track && before.sighting.frame_idx < row.sighting.frame_idx);
        }));

std::vector<Track> ReadTracks(const Hdf5Reader& file) {
  std::vector<Track> tracks;
  std::int32_t last_track = -1;
  for (const Observation& row : kObservations.Read(file)) {
    if (row.track > last_track) tracks.emplace_back();
    last_track = row.track;
    tracks.back().push_back(row.sighting);
  }
  return tracks;
}

}  // namespace

void WriteOdometry(const std::filesystem::path& path,
                   const OdometryShard& shard,
                   const std::string& config) {
  Hdf5Writer file(
      path, kOdometryFormat, kOdometryVersion, config, "metres; rad; target_from_source poses");
  kOdometryFrames.Write(shard.frames, &file);
  kPoseEdges.Write(shard.edges, &file);
  std::vector<Observation> observations;
  for (std::size_t track = 0; track < shard.tracks.size(); ++track) {
    for (const Sighting& sighting : shard.tracks[track]) {
      observations.push_back({static_cast<std::int32_t>(track), sighting});
    }
  }
  kObservations.Write(observations, &file);
  file.Close();
}

OdometryShard ReadOdometry(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kOdometryFormat, kOdometryVersion);
  return {kOdometryFrames.Read(file), kPoseEdges.Read(file), ReadTracks(file)};
}

OdometryShard ReadOdometryWithoutTracks(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kOdometryFormat, kOdometryVersion);
  return {kOdometryFrames.Read(file), kPoseEdges.Read(file), {}};
}

}  // namespace nightmap
