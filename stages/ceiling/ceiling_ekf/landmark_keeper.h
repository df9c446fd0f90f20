// SPDX-License-Identifier: Apache-2.0
// Map management: which tracks become landmarks, which sightings are believed, and when a landmark
// leaves the filter.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/ceiling/corner_tracks_io.h"
#include "stages/ceiling/ceiling_ekf/ceiling_filter.h"

namespace nightmap {

struct KeeperOptions {
  OPTION(int, max_landmarks, 48, {4, 1000},
         "landmarks in view at most; the time per frame grows with their cube");
  OPTION(std::string, initial_depth, "parallax", {"parallax", "published"},
         "what gives a new landmark its depth: two views min_parallax_rad apart, or, as in the "
         "publication CN103680291A, f T / (x1 - x2) of two pictures");
  OPTION(double, min_parallax_rad, 0.2, {0.001, 1},
         "parallax: angle between two views from which the depth of a corner is known");
  OPTION(double, gate, 18.4, {1, 1000},
         "chi-square, two degrees of freedom (99.99 %), up to which a sighting fits its landmark");
  OPTION(double, max_slip_sigmas, 4, {1, 1e9},
         "deviation of the wheels' way over the last frames from the pictures', from which they "
         "slip");
  OPTION(double, slip_gate, 12.8, {1, 1e9},
         "chi-square, three degrees of freedom (99.5 % where pictures tell all of the pose), from "
         "which they slip in one frame");
  REGISTER_OPTIONS();
};

// A landmark that left the filter. Position and covariance are in the frame of the anchor that was
// active then.
struct StoredLandmark {
  std::int64_t track_id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  // metres
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  int num_sightings = 0;
  std::int64_t last_time_ns = 0;
  Eigen::Vector2f last_raw_px = Eigen::Vector2f::Zero();
};

struct ObservedFrame {
  Innovation innovation;
  int num_misfits = 0;       // sightings of landmarks that did not fit
  bool has_slipped = false;  // the picture contradicts the wheels
};

struct KeeperCounts {
  int num_added = 0;         // landmarks
  int num_inconsistent = 0;  // deleted, because they did not fit again and again
  int num_weak = 0;          // deleted, because they left the view too early
};

// Deterministic; one thread. A landmark whose track ends left the view.
class LandmarkKeeper {
 public:
  // `filter` must outlive it.
  LandmarkKeeper(const KeeperOptions& options, CeilingFilter* filter);

  // After the filter's prediction for the frame. A sighting that does not fit alone, or not with
  // the others, is left out; a landmark with three of them in a row is deleted. A robot
  // that moved otherwise than its wheels say is believed by the picture. Tracks become landmarks
  // when the robot has moved on so far that their depth is known (CeilingFilter::AddLandmark): not
  // in a turn on the spot, and never in less than `min_parallax_rad`. With `initial_depth` of
  // "published" the first disparity will do (CeilingFilter::AddLandmarkByDisparity).
  ObservedFrame Observe(const TrackedFrame& frame, const ControlInput& motion);
  // Those that left the view since the last call, and are worth keeping.
  std::vector<StoredLandmark> TakeStored();
  // The landmarks in view.
  std::vector<StoredLandmark> Active() const;
  // All landmarks leave.
  void Finish();
  const KeeperCounts& Counts() const { return counts_; }

 private:
  // A refused track is one whose landmark did not fit; it stays refused until it ends.
  enum class State { kCandidate, kLandmark, kRefused };
  struct Followed {
    State state = State::kCandidate;
    std::int64_t clone_id = -1;  // of a candidate, with its pixel there
    Eigen::Vector2d clone_px = Eigen::Vector2d::Zero();
    int num_sightings = 0;
    int num_misfits = 0;  // in a row
    std::int64_t last_time_ns = 0;
    Eigen::Vector2f last_raw_px = Eigen::Vector2f::Zero();
  };
  std::vector<LandmarkSighting> Fitting(const std::vector<LandmarkSighting>& sightings) const;
  ObservedFrame Update(const std::vector<LandmarkSighting>& sightings, const ControlInput& motion);
  // Whether the picture contradicts the wheels; `used_` has been observed since `before`.
  bool HasSlipped(const CeilingFilter& before,
                  std::size_t num_sightings,
                  const ControlInput& motion);
  void CountMisfits(const TrackedFrame& frame, const std::vector<LandmarkSighting>& seen);
  StoredLandmark Stored(const ActiveLandmark& landmark) const;
  void RemoveEnded(const TrackedFrame& frame);
  bool AddLandmark(const CornerSighting& sighting, const Followed& followed);
  void AddLandmarks(const TrackedFrame& frame);
  void AddCandidates(const TrackedFrame& frame);
  void RemoveClones();
  bool IsWorthKeeping(const ActiveLandmark& landmark, const Followed& followed) const;

  KeeperOptions options_;
  CeilingFilter* filter_;
  std::map<std::int64_t, Followed> followed_;  // by track
  struct Clone {
    std::int64_t id = 0;
    double path_m = 0;
  };
  std::vector<Clone> clones_;
  struct Advance {
    double more_m = 0;  // than the wheels say, by the picture, along the robot's heading
    double distance_m = 0;
  };
  std::deque<Advance> advances_;  // of the last frames
  double path_m_ = 0;
  std::vector<LandmarkSighting> used_;
  std::vector<StoredLandmark> stored_;
  KeeperCounts counts_;
};

}  // namespace nightmap
