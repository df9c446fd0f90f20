// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/corner_tracks_io.h"

#include <algorithm>
#include <set>

#include "pipeline/io/hdf5_file.h"

namespace nightmap {
namespace {

constexpr char kCornerTracksFormat[] = "nightmap corner tracks";
constexpr int kCornerTracksVersion = 1;

void AppendPixel(const Eigen::Vector2f& pixel, Array<float>* array) {
  array->values.insert(array->values.end(), {pixel.x(), pixel.y()});
  ++array->rows;
}

Eigen::Vector2f PixelAt(const Array<float>& array, std::size_t row) {
  return {array.values[2 * row], array.values[2 * row + 1]};
}

bool HasTrack(const TrackedFrame& frame, std::int64_t track_id) {
  return std::ranges::binary_search(frame.sightings, track_id, {}, &CornerSighting::track_id);
}

void CheckFrames(const Hdf5Reader& file, const std::vector<TrackedFrame>& frames) {
  std::set<std::int64_t> times_ns;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    file.Demand(
        frames[i].frame_idx >= 0 && (i == 0 || frames[i].frame_idx - 1 == frames[i - 1].frame_idx),
        "frame_idx",
        "is not contiguous");
    file.Demand(times_ns.insert(frames[i].time_ns).second, "time_ns", "has a time twice");
  }
}

// Each sighting continues a track of the frame before, or begins one in the frame of its id.
void CheckTracks(const Hdf5Reader& file, const CornerTracks& tracks) {
  std::vector<std::int64_t> born;
  for (std::size_t i = 0; i < tracks.frames.size(); ++i) {
    const TrackedFrame& frame = tracks.frames[i];
    std::int64_t last_id = -1;
    for (const CornerSighting& sighting : frame.sightings) {
      const std::int64_t id = sighting.track_id;
      file.Demand(id > last_id, "track_id", "does not ascend");
      last_id = id;
      const bool is_born = id >> kTrackFeatureBits == frame.frame_idx;
      file.Demand(is_born || (i > 0 && HasTrack(tracks.frames[i - 1], id)),
                  "track_id",
                  "has a track with a gap, or that begins in another frame than its id says");
      if (is_born) born.push_back(id);
    }
  }
  const auto is_same = [](const TrackDescriptor& descriptor, std::int64_t id) {
    return descriptor.track_id == id;
  };
  file.Demand(std::ranges::equal(tracks.descriptors, born, is_same),
              "born_track_id",
              "does not list the tracks in order");
}

}  // namespace

void WriteCornerTracks(const std::filesystem::path& path,
                       const CornerTracks& tracks,
                       const std::string& config) {
  std::vector<std::int32_t> frame_idx;
  std::vector<std::int64_t> time_ns, first_sighting = {0}, track_id, born_track_id;
  std::vector<std::uint8_t> is_redetected;
  Array<float> displacement{0, 2, {}}, raw_px{0, 2, {}}, px{0, 2, {}};
  Array<std::uint8_t> descriptor{tracks.descriptors.size(), 32, {}};
  for (const TrackedFrame& frame : tracks.frames) {
    frame_idx.push_back(frame.frame_idx);
    time_ns.push_back(frame.time_ns);
    is_redetected.push_back(frame.is_redetected);
    AppendPixel(frame.median_displacement_px, &displacement);
    for (const CornerSighting& sighting : frame.sightings) {
      track_id.push_back(sighting.track_id);
      AppendPixel(sighting.raw_px, &raw_px);
      AppendPixel(sighting.px, &px);
    }
    first_sighting.push_back(static_cast<std::int64_t>(track_id.size()));
  }
  for (const TrackDescriptor& track : tracks.descriptors) {
    born_track_id.push_back(track.track_id);
    descriptor.values.insert(descriptor.values.end(), track.orb.begin(), track.orb.end());
  }
  Hdf5Writer file(path,
                  kCornerTracksFormat,
                  kCornerTracksVersion,
                  config,
                  "raw_px: pixels of the color image; px, median_displacement_px: undistorted");
  file.WriteList("frame_idx", frame_idx);
  file.WriteList("time_ns", time_ns);
  file.Write("median_displacement_px", displacement);
  file.WriteList("is_redetected", is_redetected);
  file.WriteList("first_sighting", first_sighting);
  file.WriteList("track_id", track_id);
  file.Write("raw_px", raw_px);
  file.Write("px", px);
  file.WriteList("born_track_id", born_track_id);
  file.Write("descriptor", descriptor);
  file.Close();
}

CornerTracks ReadCornerTracks(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kCornerTracksFormat, kCornerTracksVersion);
  const auto frame_idx = file.ReadList<std::int32_t>("frame_idx");
  const auto time_ns = file.ReadList<std::int64_t>("time_ns");
  const auto displacement = file.Read<float>("median_displacement_px", 2);
  const auto is_redetected = file.ReadList<std::uint8_t>("is_redetected");
  const auto track_id = file.ReadList<std::int64_t>("track_id");
  const auto first = file.ReadOffsets("first_sighting", frame_idx.size(), track_id.size());
  const auto raw_px = file.Read<float>("raw_px", 2);
  const auto px = file.Read<float>("px", 2);
  const auto born_track_id = file.ReadList<std::int64_t>("born_track_id");
  const auto descriptor = file.Read<std::uint8_t>("descriptor", 32);
  file.Demand(time_ns.size() == frame_idx.size(), "time_ns");
  file.Demand(displacement.rows == frame_idx.size(), "median_displacement_px");
  file.Demand(is_redetected.size() == frame_idx.size(), "is_redetected");
  file.Demand(raw_px.rows == track_id.size(), "raw_px");
  file.Demand(px.rows == track_id.size(), "px");
  file.Demand(descriptor.rows == born_track_id.size(), "descriptor");

  CornerTracks tracks;
  for (std::size_t i = 0; i < frame_idx.size(); ++i) {
    file.Demand(is_redetected[i] <= 1, "is_redetected");
    TrackedFrame& frame = tracks.frames.emplace_back();
    frame.frame_idx = frame_idx[i];
    frame.time_ns = time_ns[i];
    frame.median_displacement_px = PixelAt(displacement, i);
    frame.is_redetected = is_redetected[i] == 1;
    for (std::size_t k = first[i]; k < first[i + 1]; ++k) {
      frame.sightings.push_back({track_id[k], PixelAt(raw_px, k), PixelAt(px, k)});
    }
  }
  for (std::size_t i = 0; i < born_track_id.size(); ++i) {
    TrackDescriptor& track = tracks.descriptors.emplace_back();
    track.track_id = born_track_id[i];
    std::copy_n(&descriptor.values[32 * i], 32, track.orb.begin());
  }
  CheckFrames(file, tracks.frames);
  CheckTracks(file, tracks);
  return tracks;
}

}  // namespace nightmap
