// SPDX-License-Identifier: Apache-2.0
// The landmarks that left the filter, by the anchor that they hang on, and the loops between them.
#pragma once

#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "pipeline/ceiling/ceiling_map_io.h"
#include "pipeline/ceiling/corner_tracks_io.h"
#include "stages/ceiling/ceiling_ekf/ceiling_filter.h"
#include "stages/ceiling/ceiling_ekf/landmark_keeper.h"
#include "stages/ceiling/ceiling_ekf/submap_match.h"

namespace nightmap {

// Deterministic; one thread.
class Submaps {
 public:
  // `descriptors` must outlive it; ascending track_id.
  Submaps(const SubmapMatchOptions& options,
          double min_loop_path_m,
          const std::vector<TrackDescriptor>& descriptors);

  // The filter is about to leave its last anchor, on which `stored` hang, with `active` in view.
  // Looks for places within reach that were left `min_loop_path_m` ago, and closes the loop to the
  // one with most landmarks met again. None is closed when two places say that the robot is in
  // different ones, and the lesser has `max_rival_ratio` of the landmarks of the other. A landmark
  // that is met again is one landmark, and closes no other loop.
  void Leave(const std::vector<StoredLandmark>& stored,
             const std::vector<StoredLandmark>& active,
             double path_m,
             CeilingFilter* filter);

  // Anchors, landmarks in the map's frame, and loops, by all that the filter knows.
  void Describe(CeilingFilter* filter, CeilingMap* map) const;
  int NumSearchesWithoutLoop() const { return num_searches_without_loop_; }

 private:
  struct Submap {
    std::vector<StoredLandmark> landmarks;
    double path_m = 0;
  };
  using Place = std::pair<int, int>;  // submap, landmark

  std::vector<SubmapLandmark> Look(const std::vector<StoredLandmark>& landmarks) const;
  // Landmarks of a submap and its neighbours, in the frame of its anchor.
  std::vector<SubmapLandmark> Around(int anchor,
                                     CeilingFilter* filter,
                                     std::vector<Place>* places) const;
  struct Candidate {
    int anchor = 0;
    SubmapMatch match;
    std::vector<Place> places;  // of the landmarks of `then`
    Rigid2 map_from_last;       // by the match
  };
  std::vector<Candidate> Candidates(const std::vector<SubmapLandmark>& now,
                                    double path_m,
                                    CeilingFilter* filter);
  // The candidate with most pairs; none when another contradicts it.
  const Candidate* Best(const std::vector<Candidate>& candidates) const;
  void Merge(const StoredLandmark& again, const Place& place);

  SubmapMatchOptions options_;
  double min_loop_path_m_;
  const std::vector<TrackDescriptor>& descriptors_;
  std::vector<Submap> submaps_;
  std::set<std::int64_t> met_again_;  // tracks
  std::vector<MetAgain> met_pairs_;
  std::vector<CeilingLoop> loops_;
  int num_searches_without_loop_ = 0;
};

}  // namespace nightmap
