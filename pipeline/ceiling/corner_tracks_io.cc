// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/corner_tracks_io.h"

#include <algorithm>
#include <set>

#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kCornerTracksFormat[] = "nightmap corner tracks";
constexpr int kCornerTracksVersion = 1;
constexpr char kIsNotContiguous[] = "is not contiguous";

constexpr auto kSightings =
    Hdf5Table<CornerSighting>(Hdf5Column("track_id", &CornerSighting::track_id),
                              Hdf5Column("raw_px", &CornerSighting::raw_px),
                              Hdf5Column("px", &CornerSighting::px));

constexpr auto kTrackedFrames = Hdf5Table<TrackedFrame>(
    Hdf5Column("frame_idx", &TrackedFrame::frame_idx)
        .Elements(kNotNegative, kIsNotContiguous)
        .Pairs([](const TrackedFrame& before,
                  const TrackedFrame& frame) { return frame.frame_idx - 1 == before.frame_idx; },
               kIsNotContiguous),
    Hdf5Column("time_ns", &TrackedFrame::time_ns),
    Hdf5Column("median_displacement_px", &TrackedFrame::median_displacement_px),
    Hdf5Column("is_redetected", &TrackedFrame::is_redetected),
    Hdf5Lists("first_sighting", &TrackedFrame::sightings, kSightings));

constexpr auto kTrackDescriptors =
    Hdf5Table<TrackDescriptor>(Hdf5Column("born_track_id", &TrackDescriptor::track_id),
                               Hdf5Column("descriptor", &TrackDescriptor::orb));

bool HasTrack(const TrackedFrame& frame, std::int64_t track_id) {
  return std::ranges::binary_search(frame.sightings, track_id, {}, &CornerSighting::track_id);
}

void CheckTimes(const Hdf5Reader& file, const std::vector<TrackedFrame>& frames) {
  std::set<std::int64_t> times_ns;
  for (const TrackedFrame& frame : frames) {
    file.Demand(times_ns.insert(frame.time_ns).second, "time_ns", "has a time twice");
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
  Hdf5Writer file(path,
                  kCornerTracksFormat,
                  kCornerTracksVersion,
                  config,
                  "raw_px: pixels of the color image; px, median_displacement_px: undistorted");
  kTrackedFrames.Write(tracks.frames, &file);
  kTrackDescriptors.Write(tracks.descriptors, &file);
  file.Close();
}

CornerTracks ReadCornerTracks(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kCornerTracksFormat, kCornerTracksVersion);
  const CornerTracks tracks{kTrackedFrames.Read(file), kTrackDescriptors.Read(file)};
  CheckTimes(file, tracks.frames);
  CheckTracks(file, tracks);
  return tracks;
}

}  // namespace nightmap
