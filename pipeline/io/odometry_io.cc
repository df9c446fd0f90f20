// SPDX-License-Identifier: Apache-2.0
// Arrays (F frames, E edges, O observations): frame_idx, state, is_keyframe F; shard_from_camera
// F x 7; edge_frame E x 2; edge_b_from_a E x 7; edge_covariance E x 36; edge_is_bridge E;
// observation O x 3 (track, frame, feature).
#include "pipeline/io/odometry_io.h"

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/pose_arrays.h"

namespace nightmap {
namespace {

constexpr char kOdometryFormat[] = "nightmap odometry";
constexpr int kOdometryVersion = 1;

void WriteFrames(const std::vector<OdometryFrame>& frames, Hdf5Writer* file) {
  std::vector<std::int32_t> frame_idx;
  std::vector<std::uint8_t> state, is_keyframe;
  Array<double> pose{0, 7, {}};
  for (const OdometryFrame& frame : frames) {
    frame_idx.push_back(frame.frame_idx);
    state.push_back(static_cast<std::uint8_t>(frame.state));
    is_keyframe.push_back(frame.is_keyframe);
    AppendPose(frame.shard_from_camera, &pose);
  }
  file->WriteList("frame_idx", frame_idx);
  file->WriteList("state", state);
  file->WriteList("is_keyframe", is_keyframe);
  file->Write("shard_from_camera", pose);
}

void WriteEdges(const std::vector<PoseEdge>& edges, Hdf5Writer* file) {
  Array<std::int32_t> frame{edges.size(), 2, {}};
  Array<double> pose{0, 7, {}};
  Array<double> covariance{0, 36, {}};
  std::vector<std::uint8_t> is_bridge;
  for (const PoseEdge& edge : edges) {
    frame.values.insert(frame.values.end(), {edge.frame_a, edge.frame_b});
    AppendPose(edge.b_from_a, &pose);
    AppendCovariance(edge.covariance, &covariance);
    is_bridge.push_back(edge.is_bridge);
  }
  file->Write("edge_frame", frame);
  file->Write("edge_b_from_a", pose);
  file->Write("edge_covariance", covariance);
  file->WriteList("edge_is_bridge", is_bridge);
}

std::vector<OdometryFrame> ReadOdometryFrames(const Hdf5Reader& file) {
  const auto frame_idx = file.ReadList<std::int32_t>("frame_idx");
  const auto state = file.ReadList<std::uint8_t>("state");
  const auto is_keyframe = file.ReadList<std::uint8_t>("is_keyframe");
  const auto pose = file.Read<double>("shard_from_camera", 7);
  file.Demand(state.size() == frame_idx.size(), "state");
  file.Demand(is_keyframe.size() == frame_idx.size(), "is_keyframe");
  file.Demand(pose.rows == frame_idx.size(), "shard_from_camera");
  std::vector<OdometryFrame> frames;
  for (std::size_t i = 0; i < frame_idx.size(); ++i) {
    file.Demand(frame_idx[i] >= 0 && (i == 0 || frame_idx[i - 1] == frame_idx[i] - 1), "frame_idx");
    file.Demand(state[i] <= static_cast<int>(TrackingState::kStarted), "state");
    frames.push_back({frame_idx[i],
                      PoseAt(pose, i, file.Path()),
                      static_cast<TrackingState>(state[i]),
                      is_keyframe[i] != 0});
  }
  return frames;
}

std::vector<PoseEdge> ReadEdges(const Hdf5Reader& file) {
  const auto frame = file.Read<std::int32_t>("edge_frame", 2);
  const auto pose = file.Read<double>("edge_b_from_a", 7);
  const auto covariance = file.Read<double>("edge_covariance", 36);
  const auto is_bridge = file.ReadList<std::uint8_t>("edge_is_bridge");
  file.Demand(pose.rows == frame.rows, "edge_b_from_a");
  file.Demand(covariance.rows == frame.rows, "edge_covariance");
  file.Demand(is_bridge.size() == frame.rows, "edge_is_bridge");
  std::vector<PoseEdge> edges;
  for (std::size_t i = 0; i < frame.rows; ++i) {
    edges.push_back({frame.values[2 * i],
                     frame.values[2 * i + 1],
                     PoseAt(pose, i, file.Path()),
                     CovarianceAt(covariance, i),
                     is_bridge[i] != 0});
    file.Demand(edges[i].frame_a >= 0 && edges[i].frame_a < edges[i].frame_b, "edge_frame");
  }
  return edges;
}

// Rows of a track follow each other. A track that lost all its sightings has no row, so its number
// is missing.
std::vector<Track> ReadTracks(const Hdf5Reader& file) {
  const auto observation = file.Read<std::int32_t>("observation", 3);
  std::vector<Track> tracks;
  std::int32_t last_track = -1;
  for (std::size_t i = 0; i < observation.rows; ++i) {
    const std::int32_t* row = observation.values.data() + 3 * i;
    const Sighting sighting{row[1], row[2]};
    file.Demand(row[0] >= 0 && row[1] >= 0 && row[2] >= 0, "observation");
    file.Demand(row[0] >= last_track, "observation");
    if (row[0] > last_track) tracks.emplace_back();
    last_track = row[0];
    Track& track = tracks.back();
    file.Demand(track.empty() || track.back().frame_idx < sighting.frame_idx, "observation");
    track.push_back(sighting);
  }
  return tracks;
}

}  // namespace

void WriteOdometry(const std::filesystem::path& path,
                   const OdometryShard& shard,
                   const std::string& config) {
  Hdf5Writer file(
      path, kOdometryFormat, kOdometryVersion, config, "metres; rad; target_from_source poses");
  WriteFrames(shard.frames, &file);
  WriteEdges(shard.edges, &file);
  Array<std::int32_t> observation{0, 3, {}};
  for (std::size_t track = 0; track < shard.tracks.size(); ++track) {
    for (const Sighting& s : shard.tracks[track]) {
      observation.values.insert(observation.values.end(),
                                {static_cast<std::int32_t>(track), s.frame_idx, s.feature_idx});
      ++observation.rows;
    }
  }
  file.Write("observation", observation);
  file.Close();
}

OdometryShard ReadOdometry(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kOdometryFormat, kOdometryVersion);
  return {ReadOdometryFrames(file), ReadEdges(file), ReadTracks(file)};
}

}  // namespace nightmap
