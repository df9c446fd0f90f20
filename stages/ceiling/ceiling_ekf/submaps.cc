// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/submaps.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "pipeline/ceiling/planar_pose.h"

namespace nightmap {
namespace {

constexpr double kView_m = 6;  // two places farther apart have no ceiling in common
// Two loops that put the robot so far apart contradict each other.
constexpr double kElsewhere_m = 0.3;
constexpr double kElsewhere_rad = 0.15;

Eigen::Vector3d MovedBy(const Rigid2& pose, const Eigen::Vector3d& point) {
  Eigen::Vector3d moved;
  moved << pose * point.head<2>(), point.z();
  return moved;
}

}  // namespace

Submaps::Submaps(const SubmapMatchOptions& options,
                 double min_loop_path_m,
                 const std::vector<TrackDescriptor>& descriptors)
    : options_(options), min_loop_path_m_(min_loop_path_m), descriptors_(descriptors) {}

std::vector<SubmapLandmark> Submaps::Look(const std::vector<StoredLandmark>& landmarks) const {
  std::vector<SubmapLandmark> look;
  for (const StoredLandmark& landmark : landmarks) {
    const auto descriptor =
        std::ranges::lower_bound(descriptors_, landmark.track_id, {}, &TrackDescriptor::track_id);
    look.push_back({landmark.position, descriptor->orb});
  }
  return look;
}

std::vector<SubmapLandmark> Submaps::Around(int anchor,
                                            CeilingFilter* filter,
                                            std::vector<Place>* places) const {
  std::vector<StoredLandmark> around;
  const Rigid2 anchor_from_map = filter->MapFromAnchor(anchor).Inverse();
  for (int i = std::max(0, anchor - 1); i <= anchor + 1; ++i) {
    const Rigid2 anchor_from_other = anchor_from_map * filter->MapFromAnchor(i);
    const std::vector<StoredLandmark>& landmarks = submaps_[static_cast<std::size_t>(i)].landmarks;
    for (std::size_t j = 0; j < landmarks.size(); ++j) {
      StoredLandmark moved = landmarks[j];
      moved.position = MovedBy(anchor_from_other, moved.position);
      around.push_back(moved);
      places->emplace_back(i, static_cast<int>(j));
    }
  }
  return Look(around);
}

void Submaps::Merge(const StoredLandmark& again, const Place& place) {
  met_again_.insert(again.track_id);
  StoredLandmark& first = submaps_[static_cast<std::size_t>(place.first)]
                              .landmarks[static_cast<std::size_t>(place.second)];
  met_pairs_.push_back({again.track_id, first.track_id});
  first.num_sightings += again.num_sightings;
  first.last_time_ns = again.last_time_ns;
  first.last_raw_px = again.last_raw_px;
}

std::vector<Submaps::Candidate> Submaps::Candidates(const std::vector<SubmapLandmark>& now,
                                                    double path_m,
                                                    CeilingFilter* filter) {
  std::vector<Candidate> candidates;
  bool was_looked_for = false;
  const int last = static_cast<int>(submaps_.size());
  for (int anchor = 0; anchor + 1 < last; ++anchor) {
    if (path_m - submaps_[static_cast<std::size_t>(anchor) + 1].path_m < min_loop_path_m_) break;
    const Rigid2 map_from_anchor = filter->MapFromAnchor(anchor);
    const Rigid2 expected = filter->MapFromAnchor(last).Inverse() * map_from_anchor;
    const Eigen::Matrix3d covariance = filter->RelativeCovariance(anchor);
    const double sigma_m = std::sqrt(covariance(0, 0) + covariance(1, 1));
    if (expected.translation.norm() > kView_m + 3 * sigma_m) continue;
    was_looked_for = true;
    std::vector<Place> places;
    const std::vector<SubmapLandmark> then = Around(anchor, filter, &places);
    auto match = MatchSubmaps(options_, now, then, expected, covariance);
    if (!match) continue;
    const Rigid2 map_from_last = map_from_anchor * match->now_from_then.Inverse();
    candidates.push_back({anchor, std::move(*match), std::move(places), map_from_last});
  }
  num_searches_without_loop_ += was_looked_for && candidates.empty();
  return candidates;
}

const Submaps::Candidate* Submaps::Best(const std::vector<Candidate>& candidates) const {
  if (candidates.empty()) return nullptr;
  const auto num_pairs = [](const Candidate& candidate) { return candidate.match.pairs.size(); };
  const Candidate& best = *std::ranges::max_element(candidates, {}, num_pairs);
  const auto limit = options_.max_rival_ratio * static_cast<double>(num_pairs(best));
  for (const Candidate& other : candidates) {
    const Rigid2 off = best.map_from_last.Inverse() * other.map_from_last;
    const bool is_elsewhere =
        off.translation.norm() > kElsewhere_m || std::abs(off.heading_rad) > kElsewhere_rad;
    if (is_elsewhere && static_cast<double>(num_pairs(other)) >= limit) return nullptr;
  }
  return &best;
}

void Submaps::Leave(const std::vector<StoredLandmark>& stored,
                    const std::vector<StoredLandmark>& active,
                    double path_m,
                    CeilingFilter* filter) {
  std::vector<StoredLandmark> seen;
  for (const auto* landmarks : {&stored, &active}) {
    std::ranges::copy_if(*landmarks, std::back_inserter(seen), [&](const StoredLandmark& landmark) {
      return !met_again_.contains(landmark.track_id);
    });
  }
  const std::vector<Candidate> candidates = Candidates(Look(seen), path_m, filter);
  if (const Candidate* best = Best(candidates)) {
    filter->CloseLoop(best->anchor, best->match.now_from_then, best->match.covariance);
    loops_.push_back({static_cast<int>(submaps_.size()),
                      best->anchor,
                      static_cast<int>(best->match.pairs.size())});
    for (const auto& [i, j] : best->match.pairs) {
      Merge(seen[static_cast<std::size_t>(i)], best->places[static_cast<std::size_t>(j)]);
    }
  }
  Submap& submap = submaps_.emplace_back();
  submap.path_m = path_m;
  std::ranges::copy_if(
      stored, std::back_inserter(submap.landmarks), [&](const StoredLandmark& landmark) {
        return !met_again_.contains(landmark.track_id);
      });
}

void Submaps::Describe(CeilingFilter* filter, CeilingMap* map) const {
  for (int anchor = 0; anchor < static_cast<int>(submaps_.size()); ++anchor) {
    const Rigid2 map_from_anchor = filter->MapFromAnchor(anchor);
    const Eigen::Matrix3d covariance = filter->AnchorCovariance(anchor);
    map->anchors.push_back({map_from_anchor, covariance});
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(map_from_anchor.heading_rad).toRotationMatrix();
    for (const StoredLandmark& stored : submaps_[static_cast<std::size_t>(anchor)].landmarks) {
      CeilingLandmark landmark;
      landmark.track_id = stored.track_id;
      landmark.anchor = anchor;
      landmark.position_m = MovedBy(map_from_anchor, stored.position);
      const Eigen::Vector3d arm = turn * stored.position;
      Eigen::Matrix3d by_anchor = Eigen::Matrix3d::Zero();
      by_anchor << 1, 0, -arm.y(), 0, 1, arm.x(), 0, 0, 0;
      landmark.covariance_m2 = by_anchor * covariance * by_anchor.transpose() +
                               turn * stored.covariance * turn.transpose();
      landmark.num_sightings = stored.num_sightings;
      landmark.last_time_ns = stored.last_time_ns;
      landmark.last_raw_px = stored.last_raw_px;
      map->landmarks.push_back(landmark);
    }
  }
  map->loops = loops_;
  map->met_again = met_pairs_;
}

}  // namespace nightmap
