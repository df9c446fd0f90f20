// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/tracks_by_projection.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "pipeline/geometry/bundle_adjustment.h"
#include "stages/camera/adjust/global_bundle.h"
#include "tests/landmark_scene.h"

namespace nightmap::tracks_by_projection_test {

struct Retracked {
  LandmarkScene scene = MakeLandmarkScene();
  AdjustInput input;
  std::map<int, Rigid3> poses;

  Retracked() {
    input.frames = scene.frames;
    input.features = SiteFeatures(scene.features);
    input.cameras = scene.cameras;
    for (std::size_t i = 0; i < scene.poses.size(); ++i) {
      poses[static_cast<int>(i)] = scene.poses[i].pose;
    }
  }
};

std::vector<Track> Retrack(const Retracked& r,
                           const LandmarkTrackerOptions& options,
                           int num_threads) {
  const TrackList found = TracksByProjection(r.input, r.poses, options, num_threads);
  std::vector<Track> tracks;
  for (std::size_t i = 0; i < found.size(); ++i)
    tracks.emplace_back(found[i].begin(), found[i].end());
  return tracks;
}

// Every point seen twice or more is one track with all its sightings, and none joins two points.
TEST(TracksByProjection, ATrackIsAPointWithAllItsSightings) {
  const Retracked r;
  std::map<int, std::size_t> num_seen;
  for (const auto& points : r.scene.frame_points) {
    for (const int point : points) ++num_seen[point];
  }
  const auto num_shared =
      std::ranges::count_if(num_seen, [](const auto& entry) { return entry.second > 1; });
  std::set<int> found;
  for (const Track& track : Retrack(r, {.max_error_px = 3.0}, 2)) {
    std::set<int> points;
    for (const auto& [frame, feature] : track) {
      points.insert(
          r.scene.frame_points[static_cast<std::size_t>(frame)][static_cast<std::size_t>(feature)]);
    }
    ASSERT_EQ(points.size(), 1U);
    EXPECT_EQ(track.size(), num_seen.at(*points.begin()));
    EXPECT_TRUE(found.insert(*points.begin()).second) << "a point is two tracks";
  }
  EXPECT_EQ(static_cast<std::ptrdiff_t>(found.size()), num_shared);
}

// A site that is cut has the same tracks, but for some at the borders that lose a sighting.
TEST(TracksByProjection, ACutSiteHasNearlyTheSameTracks) {
  Retracked r;
  GoAgain(&r.scene);
  r.input.frames = r.scene.frames;
  r.input.features = SiteFeatures(r.scene.features);
  for (std::size_t i = 0; i < r.scene.frames.size(); ++i) {
    r.poses[static_cast<int>(i)] = r.scene.poses[i % r.scene.poses.size()].pose;
  }
  const LandmarkTrackerOptions options{.max_error_px = 3.0, .voxel_size_m = 0.05};
  const auto whole = Retrack(r, options, 1);
  r.input.max_region_observers = 5;
  const auto cut = Retrack(r, options, 1);
  EXPECT_EQ(cut, Retrack(r, options, 4));
  EXPECT_NE(cut, whole);  // in the order of the regions
  const std::set<Track> of_whole(whole.begin(), whole.end());
  const auto num_same =
      std::ranges::count_if(cut, [&](const Track& track) { return of_whole.contains(track); });
  EXPECT_GT(static_cast<double>(num_same), 0.98 * static_cast<double>(whole.size()));
  std::set<Sighting> seen;
  for (const Track& track : cut) {
    for (const Sighting& s : track) EXPECT_TRUE(seen.insert(s).second);
  }
}

// A feature at the right place that is only half as unlike as a stranger is no sighting: it may be
// a neighbour of the right one, and such pairs hold the poses where they are.
TEST(TracksByProjection, AFeatureThatIsOnlySomewhatAlikeIsNoSighting) {
  Retracked r;
  FrameFeatures& frame = r.scene.features.frames[3];
  for (std::size_t i = 0; i < frame.descriptors.size(); ++i) {
    const std::uint8_t strange = frame.descriptors[(i + 128) % frame.descriptors.size()];
    frame.descriptors[i] = static_cast<std::uint8_t>(0.4 * frame.descriptors[i] + 0.6 * strange);
  }
  r.input.features = SiteFeatures(r.scene.features);
  const auto num_sightings = [&](const LandmarkTrackerOptions& options) {
    std::ptrdiff_t count = 0;
    for (const Track& track : Retrack(r, options, 2)) {
      count += std::ranges::count(track, 3, &Sighting::frame_idx);
    }
    return count;
  };
  EXPECT_EQ(num_sightings(AdjustOptions{}.retrack), 0);
  EXPECT_GT(num_sightings({.max_error_px = 3.0, .max_descriptor_distance = 0.6}), 100);
}

TEST(TracksByProjection, AFrameThatWasOnlyTrackedHasNoSighting) {
  Retracked r;
  TrackFrom(2, 3, &r.scene);
  r.input.features = SiteFeatures(r.scene.features);
  const auto tracks = Retrack(r, {.max_error_px = 3.0}, 2);
  EXPECT_GT(tracks.size(), 100U);
  for (const Track& track : tracks) {
    for (const auto& [frame, feature] : track) EXPECT_NE(frame, 3);
  }
}

// A pose that is a centimetre off is put right by points found from there.
TEST(TracksByProjection, TheTracksPutAPoseRight) {
  Retracked r;
  const Rigid3 truth = r.poses.at(4);
  r.poses.at(4).translation += Eigen::Vector3d(0.01, -0.008, 0.004);
  const auto tracks = TracksByProjection(r.input, r.poses, {.max_error_px = 6.0}, 2);
  const auto summary = AdjustFrames(r.input, {.loss = RobustLoss::kCauchy}, tracks, {}, &r.poses);
  EXPECT_EQ(summary.adjustments.size(), 2U);
  EXPECT_LT((r.poses.at(4).translation - truth.translation).norm(), 5e-4);
}

}  // namespace nightmap::tracks_by_projection_test
