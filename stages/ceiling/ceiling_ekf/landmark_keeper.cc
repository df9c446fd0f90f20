// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/landmark_keeper.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>

#include "pipeline/ceiling/planar_pose.h"

namespace nightmap {
namespace {

// Way between the views from which new corners are followed.
constexpr double kCloneDistance_m = 0.15;
constexpr int kMaxClones = 12;  // of these, remembered at most
// Sightings in a row that do not fit, from which a landmark is deleted.
constexpr int kMaxMisfits = 3;
constexpr int kMinSightings = 5;  // sightings that a landmark of the map has at least
// Deviation of a landmark of the map at most, on each axis of its anchor.
constexpr double kMaxSigma_m = 0.05;
constexpr std::size_t kMinForSlip = 4;     // landmarks that can tell of it
constexpr double kMaxResidual_sigmas = 4;  // after the update
constexpr int kMaxRounds = 3;
constexpr int kMaxPerCell = 2;  // landmarks
constexpr std::size_t kSlipFrames = 10;
constexpr double kSeenSigma_m = 0.002;  // of a way that pictures measure
constexpr double kCellSize_px = 64;     // side of the cells that landmarks are spread over

// The robot went anywhere near: its wheels say too much, or too little.
Eigen::Vector3d SlipSigma(const ControlInput& motion) {
  return {motion.distance_m + 0.03, 0.3 * motion.distance_m + 0.01, motion.turn_rad + 0.03};
}

// How much farther the robot is in `after` than in `before`, ahead.
double MoreAlong(const CeilingFilter& before, const CeilingFilter& after) {
  return (before.AnchorFromRobot().Inverse() * after.AnchorFromRobot()).translation.x();
}

std::pair<int, int> CellOf(const Eigen::Vector2f& pixel) {
  const Eigen::Vector2d cell = pixel.cast<double>() / kCellSize_px;
  return {static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y()))};
}

}  // namespace

LandmarkKeeper::LandmarkKeeper(const KeeperOptions& options, CeilingFilter* filter)
    : options_(options), filter_(filter) {}

std::vector<LandmarkSighting> LandmarkKeeper::Fitting(
    const std::vector<LandmarkSighting>& sightings) const {
  const std::vector<double> gates = filter_->Gates(sightings);
  std::vector<LandmarkSighting> fitting;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (gates[i] < options_.gate) fitting.push_back(sightings[i]);
  }
  return fitting;
}

ObservedFrame LandmarkKeeper::Update(const std::vector<LandmarkSighting>& sightings,
                                     const ControlInput& motion) {
  ObservedFrame observed;
  CeilingFilter before = *filter_;
  used_ = Fitting(sightings);
  observed.innovation = filter_->Observe(used_);
  if (sightings.size() < kMinForSlip || motion.unknown_time_s > 0) {
    advances_.clear();
  } else {
    observed.has_slipped = HasSlipped(before, sightings.size(), motion);
  }
  if (observed.has_slipped) {
    before.Loosen(SlipSigma(motion));
    *filter_ = before;
    used_ = Fitting(sightings);
    observed.innovation = filter_->Observe(used_);
  }
  // Sightings that do not fit the others are left out, and what they did is undone.
  for (int round = 0; round < kMaxRounds; ++round) {
    std::vector<LandmarkSighting> agreeing = filter_->Agreeing(used_, kMaxResidual_sigmas);
    if (agreeing.size() == used_.size()) break;
    used_ = std::move(agreeing);
    *filter_ = before;
    observed.innovation = filter_->Observe(used_);
  }
  observed.num_misfits = static_cast<int>(sightings.size() - used_.size());
  return observed;
}

bool LandmarkKeeper::HasSlipped(const CeilingFilter& before,
                                std::size_t num_sightings,
                                const ControlInput& motion) {
  // A leap counts for this frame alone; slipping that lasts shows in the sum over some frames.
  if (2 * used_.size() < num_sightings) return true;
  if (before.Surprise(*filter_) > options_.slip_gate) return true;
  advances_.push_back({MoreAlong(before, *filter_), motion.distance_m});
  if (advances_.size() > kSlipFrames) advances_.pop_front();
  double more_m = 0, distance_m = 0;
  for (const Advance& advance : advances_) {
    more_m += advance.more_m;
    distance_m += advance.distance_m;
  }
  // Independent errors of the wheels add up like the root of the way, slipping like the way.
  const double sigma_m = filter_->WheelSigma_m(distance_m) + kSeenSigma_m;
  return std::abs(more_m) > options_.max_slip_sigmas * sigma_m;
}

void LandmarkKeeper::CountMisfits(const TrackedFrame& frame,
                                  const std::vector<LandmarkSighting>& seen) {
  std::vector<std::int64_t> inconsistent;
  for (const LandmarkSighting& sighting : seen) {
    Followed& followed = followed_.at(sighting.track_id);
    const bool is_used =
        std::ranges::binary_search(used_, sighting.track_id, {}, &LandmarkSighting::track_id);
    if (is_used) {
      followed.num_misfits = 0;
      ++followed.num_sightings;
      followed.last_time_ns = frame.time_ns;
      followed.last_raw_px = std::ranges::lower_bound(
                                 frame.sightings, sighting.track_id, {}, &CornerSighting::track_id)
                                 ->raw_px;
    } else if (++followed.num_misfits >= kMaxMisfits) {
      inconsistent.push_back(sighting.track_id);
      followed.state = State::kRefused;
      ++counts_.num_inconsistent;
    }
  }
  filter_->RemoveLandmarks(inconsistent);
}

void LandmarkKeeper::RemoveEnded(const TrackedFrame& frame) {
  std::set<std::int64_t> ended;
  for (const auto& [track_id, followed] : followed_) {
    if (!std::ranges::binary_search(frame.sightings, track_id, {}, &CornerSighting::track_id)) {
      ended.insert(track_id);
    }
  }
  std::vector<std::int64_t> left;
  for (const ActiveLandmark& landmark : filter_->Landmarks()) {
    if (!ended.contains(landmark.track_id)) continue;
    const Followed& followed = followed_.at(landmark.track_id);
    if (IsWorthKeeping(landmark, followed)) {
      stored_.push_back(Stored(landmark));
    } else {
      ++counts_.num_weak;
    }
    left.push_back(landmark.track_id);
  }
  filter_->RemoveLandmarks(left);
  for (const std::int64_t track_id : ended) followed_.erase(track_id);
}

bool LandmarkKeeper::IsWorthKeeping(const ActiveLandmark& landmark,
                                    const Followed& followed) const {
  return followed.num_sightings >= kMinSightings &&
         landmark.covariance.diagonal().maxCoeff() < kMaxSigma_m * kMaxSigma_m;
}

bool LandmarkKeeper::AddLandmark(const CornerSighting& sighting, const Followed& followed) {
  const Eigen::Vector2d now = sighting.px.cast<double>();
  if (options_.initial_depth == "published") {
    return filter_->AddLandmarkByDisparity(
        sighting.track_id, followed.clone_id, followed.clone_px, now);
  }
  return filter_->AddLandmark(sighting.track_id,
                              followed.clone_id,
                              followed.clone_px,
                              now,
                              options_.min_parallax_rad,
                              options_.gate);
}

void LandmarkKeeper::AddLandmarks(const TrackedFrame& frame) {
  std::map<std::pair<int, int>, int> num_in_cell;
  int num_landmarks = 0;
  for (const CornerSighting& sighting : frame.sightings) {
    const auto found = followed_.find(sighting.track_id);
    if (found == followed_.end() || found->second.state != State::kLandmark) continue;
    ++num_in_cell[CellOf(sighting.px)];
    ++num_landmarks;
  }
  for (const CornerSighting& sighting : frame.sightings) {
    if (num_landmarks >= options_.max_landmarks) return;
    const auto found = followed_.find(sighting.track_id);
    if (found == followed_.end() || found->second.state != State::kCandidate) continue;
    int& num_here = num_in_cell[CellOf(sighting.px)];
    if (num_here >= kMaxPerCell) continue;
    Followed& followed = found->second;
    if (!AddLandmark(sighting, followed)) continue;
    followed.state = State::kLandmark;
    followed.num_sightings = 2;
    followed.last_time_ns = frame.time_ns;
    followed.last_raw_px = sighting.raw_px;
    ++counts_.num_added;
    ++num_here;
    ++num_landmarks;
  }
}

void LandmarkKeeper::AddCandidates(const TrackedFrame& frame) {
  if (!clones_.empty() && path_m_ - clones_.back().path_m < kCloneDistance_m) return;
  std::vector<const CornerSighting*> candidates;
  for (const CornerSighting& sighting : frame.sightings) {
    if (!followed_.contains(sighting.track_id)) candidates.push_back(&sighting);
  }
  if (candidates.empty()) return;
  const std::int64_t clone_id = filter_->AddClone();
  clones_.push_back({clone_id, path_m_});
  for (const CornerSighting* sighting : candidates) {
    Followed& followed = followed_[sighting->track_id];
    followed.clone_id = clone_id;
    followed.clone_px = sighting->px.cast<double>();
  }
}

void LandmarkKeeper::RemoveClones() {
  std::set<std::int64_t> needed;
  if (static_cast<int>(clones_.size()) > kMaxClones) {
    std::erase_if(followed_, [&](const auto& entry) {
      return entry.second.state == State::kCandidate && entry.second.clone_id == clones_.front().id;
    });
  }
  for (const auto& [track_id, followed] : followed_) {
    if (followed.state == State::kCandidate) needed.insert(followed.clone_id);
  }
  std::vector<std::int64_t> useless;
  for (const Clone& clone : clones_) {
    if (!needed.contains(clone.id)) useless.push_back(clone.id);
  }
  std::erase_if(clones_, [&](const Clone& clone) { return !needed.contains(clone.id); });
  filter_->RemoveClones(useless);
}

ObservedFrame LandmarkKeeper::Observe(const TrackedFrame& frame, const ControlInput& motion) {
  path_m_ += motion.before_from_after.translation.norm();
  RemoveEnded(frame);
  std::vector<LandmarkSighting> seen;
  for (const CornerSighting& sighting : frame.sightings) {
    const auto found = followed_.find(sighting.track_id);
    if (found == followed_.end()) continue;
    if (found->second.state == State::kLandmark) {
      seen.push_back({sighting.track_id, sighting.px.cast<double>()});
    }
  }
  const ObservedFrame observed = Update(seen, motion);
  CountMisfits(frame, seen);
  AddLandmarks(frame);
  AddCandidates(frame);
  RemoveClones();
  return observed;
}

StoredLandmark LandmarkKeeper::Stored(const ActiveLandmark& landmark) const {
  const Followed& followed = followed_.at(landmark.track_id);
  return {landmark.track_id,
          landmark.position,
          landmark.covariance,
          followed.num_sightings,
          followed.last_time_ns,
          followed.last_raw_px};
}

std::vector<StoredLandmark> LandmarkKeeper::TakeStored() {
  std::vector<StoredLandmark> stored;
  stored.swap(stored_);
  return stored;
}

std::vector<StoredLandmark> LandmarkKeeper::Active() const {
  std::vector<StoredLandmark> active;
  for (const ActiveLandmark& landmark : filter_->Landmarks()) {
    if (IsWorthKeeping(landmark, followed_.at(landmark.track_id))) {
      active.push_back(Stored(landmark));
    }
  }
  return active;
}

void LandmarkKeeper::Finish() {
  RemoveEnded(TrackedFrame{});
  RemoveClones();
}

}  // namespace nightmap
