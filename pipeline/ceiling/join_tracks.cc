// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/join_tracks.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

#include "pipeline/base/input_error.h"

namespace nightmap {
namespace {

using Renamed = std::map<std::int64_t, std::int64_t>;

// later id -> earlier id, of tracks that meet in the shared frame.
Renamed MeetIn(const TrackedFrame& before, const TrackedFrame& after, double max_distance_px) {
  std::vector<std::tuple<float, std::int64_t, std::int64_t>> pairs;
  for (const CornerSighting& a : before.sightings) {
    for (const CornerSighting& b : after.sightings) {
      const float distance_px = (a.raw_px - b.raw_px).norm();
      if (distance_px <= static_cast<float>(max_distance_px)) {
        pairs.emplace_back(distance_px, a.track_id, b.track_id);
      }
    }
  }
  std::ranges::sort(pairs);
  std::set<std::int64_t> is_continued;
  Renamed renamed;
  for (const auto& [distance_px, earlier, later] : pairs) {
    if (renamed.contains(later) || !is_continued.insert(earlier).second) continue;
    renamed[later] = earlier;
  }
  return renamed;
}

void Append(CornerTracks shard, const Renamed& renamed, CornerTracks* joined) {
  for (std::size_t i = 1; i < shard.frames.size(); ++i) {
    TrackedFrame& frame = joined->frames.emplace_back(std::move(shard.frames[i]));
    for (CornerSighting& sighting : frame.sightings) {
      const auto found = renamed.find(sighting.track_id);
      if (found != renamed.end()) sighting.track_id = found->second;
    }
    std::ranges::sort(frame.sightings, {}, &CornerSighting::track_id);
  }
  for (const TrackDescriptor& descriptor : shard.descriptors) {
    if (!renamed.contains(descriptor.track_id)) joined->descriptors.push_back(descriptor);
  }
}

}  // namespace

CornerTracks JoinTracks(std::vector<CornerTracks> shards, double max_distance_px) {
  CornerTracks joined;
  for (std::size_t i = 0; i < shards.size(); ++i) {
    if (i == 0) {
      joined = std::move(shards[0]);
      continue;
    }
    const bool follows = !joined.frames.empty() && !shards[i].frames.empty() &&
                         joined.frames.back().frame_idx == shards[i].frames.front().frame_idx;
    if (!follows) {
      throw InputError({{"tracks", i - 1}, {"tracks", i}},
                       "the second does not begin with the last frame of the first");
    }
    const Renamed renamed = MeetIn(joined.frames.back(), shards[i].frames.front(), max_distance_px);
    Append(std::move(shards[i]), renamed, &joined);
  }
  std::ranges::sort(joined.descriptors, {}, &TrackDescriptor::track_id);
  const auto is_same = [](const TrackDescriptor& a, const TrackDescriptor& b) {
    return a.track_id == b.track_id;
  };
  joined.descriptors.erase(
      std::unique(joined.descriptors.begin(), joined.descriptors.end(), is_same),
      joined.descriptors.end());
  return joined;
}

}  // namespace nightmap
