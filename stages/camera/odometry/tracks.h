// SPDX-License-Identifier: Apache-2.0
// Joins pairwise matches to tracks; a track is one point of the building seen by several frames.
#pragma once

#include <cstddef>
#include <vector>

#include "pipeline/base/union_find.h"
#include "pipeline/io/features_io.h"

namespace nightmap {

class TrackBuilder {
 public:
  // num_features[i] is that of frame begin_idx + i.
  TrackBuilder(int begin_idx, const std::vector<int>& num_features);

  // Declares that two features show the same point. Ignores a match that would give a track two
  // features in one frame, because it contradicts earlier matches: join the most trusted matches
  // first. Throws DataError when a frame or feature does not exist.
  void Join(int frame_a, int feature_a, int frame_b, int feature_b);

  // Tracks seen by at least two frames, in the order of their first sightings.
  std::vector<Track> Build();

 private:
  static std::vector<std::size_t> Offsets(const std::vector<int>& num_features);
  std::size_t Slot(int frame_idx, int feature_idx) const;

  int begin_idx_;
  std::vector<std::size_t> first_slot_;  // by frame; one more at the end
  UnionFind sets_;
  std::vector<std::vector<int>> frames_;  // frames of the set that a slot represents, ascending
};

}  // namespace nightmap
