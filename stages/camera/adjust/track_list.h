// SPDX-License-Identifier: Apache-2.0
// Many tracks in two arrays: millions of small vectors would take twice the memory, and leave it in
// pieces.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "pipeline/io/features_io.h"

namespace nightmap {

class TrackList {
 public:
  TrackList() = default;
  TrackList(const std::vector<Track>& tracks) {
    for (const Track& track : tracks) Add(track);
  }

  void Add(std::span<const Sighting> track) {
    sightings_.insert(sightings_.end(), track.begin(), track.end());
    begins_.push_back(sightings_.size());
  }
  // Tracks of these lengths, whose sightings are to be set.
  void AddEmpty(std::size_t length) {
    sightings_.resize(sightings_.size() + length);
    begins_.push_back(sightings_.size());
  }

  std::size_t size() const { return begins_.size() - 1; }
  std::size_t NumSightings() const { return sightings_.size(); }
  std::span<const Sighting> operator[](std::size_t i) const {
    return {sightings_.data() + begins_[i], sightings_.data() + begins_[i + 1]};
  }
  // Index of a track's first sighting among all.
  std::size_t Begin(std::size_t i) const { return begins_[i]; }
  Sighting& At(std::size_t sighting) { return sightings_[sighting]; }

  bool operator==(const TrackList&) const = default;

 private:
  std::vector<std::size_t> begins_{0};
  std::vector<Sighting> sightings_;
};

}  // namespace nightmap
