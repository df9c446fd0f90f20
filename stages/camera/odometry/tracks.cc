// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/odometry/tracks.h"

#include <algorithm>
#include <iterator>

#include "pipeline/base/input_error.h"

namespace nightmap {
namespace {

// Union of two ascending lists; empty when they share an element.
std::vector<int> DisjointUnion(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> joined;
  joined.reserve(a.size() + b.size());
  std::ranges::merge(a, b, std::back_inserter(joined));
  if (std::ranges::adjacent_find(joined) != joined.end()) joined.clear();
  return joined;
}

}  // namespace

TrackBuilder::TrackBuilder(int begin_idx, const std::vector<int>& num_features)
    : begin_idx_(begin_idx), first_slot_(Offsets(num_features)), sets_(first_slot_.back()) {
  frames_.reserve(first_slot_.back());
  for (std::size_t frame = 0; frame < num_features.size(); ++frame) {
    frames_.insert(frames_.end(),
                   static_cast<std::size_t>(num_features[frame]),
                   {begin_idx_ + static_cast<int>(frame)});
  }
}

std::vector<std::size_t> TrackBuilder::Offsets(const std::vector<int>& num_features) {
  std::vector<std::size_t> offsets = {0};
  for (const int count : num_features) {
    offsets.push_back(offsets.back() + static_cast<std::size_t>(count));
  }
  return offsets;
}

std::size_t TrackBuilder::Slot(int frame_idx, int feature_idx) const {
  const auto frame = static_cast<std::size_t>(frame_idx - begin_idx_);
  if (frame_idx < begin_idx_ || frame + 1 >= first_slot_.size() || feature_idx < 0 ||
      first_slot_[frame] + static_cast<std::size_t>(feature_idx) >= first_slot_[frame + 1]) {
    throw InputError({{"pairs"}},
                     "a match names feature {} of frame {}, which the features do not have",
                     feature_idx,
                     frame_idx);
  }
  return first_slot_[frame] + static_cast<std::size_t>(feature_idx);
}

void TrackBuilder::Join(int frame_a, int feature_a, int frame_b, int feature_b) {
  const std::size_t a = sets_.Find(Slot(frame_a, feature_a));
  const std::size_t b = sets_.Find(Slot(frame_b, feature_b));
  if (a == b) return;
  std::vector<int> joined = DisjointUnion(frames_[a], frames_[b]);
  if (joined.empty()) return;
  sets_.Join(a, b);
  frames_[std::max(a, b)].clear();
  frames_[std::min(a, b)] = std::move(joined);
}

std::vector<Track> TrackBuilder::Build() {
  std::vector<Track> tracks(first_slot_.back());
  for (std::size_t frame = 0; frame + 1 < first_slot_.size(); ++frame) {
    for (std::size_t slot = first_slot_[frame]; slot < first_slot_[frame + 1]; ++slot) {
      tracks[sets_.Find(slot)].push_back(
          {begin_idx_ + static_cast<int>(frame), static_cast<int>(slot - first_slot_[frame])});
    }
  }
  std::erase_if(tracks, [](const Track& track) { return track.size() < 2; });
  return tracks;
}

}  // namespace nightmap
