// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/doubtful_loops.h"

#include <algorithm>

#include "tests/test_data.h"

namespace nightmap::doubtful_loops_test {

// Keyscans every 2 m along x, whose motions are known to 1 mm.
struct Drive {
  std::vector<Keyscan> keyscans;
  std::vector<SensorEdge> edges;

  Drive() {
    for (int i = 0; i < 20; ++i) {
      keyscans.push_back({i, {0, {2.0 * i, 0}}, 2.0 * i, {}, {}});
      if (i > 0) {
        edges.push_back({EdgeKind::kOdometry, i - 1, i, Rigid3(), 1e-6 * Matrix6d::Identity()});
      }
    }
  }
};

// A loop to query 15, which the submap sees at `x_m` in its frame.
ScanLoopCandidate Found(std::size_t submap, double x_m, double score, double second_score = 0) {
  ScanLoopCandidate candidate;
  candidate.submap_keyscan = submap;
  candidate.query_keyscan = 15;
  candidate.score = score;
  candidate.second_score = second_score;
  candidate.is_loop = second_score == 0 && score > 0;
  candidate.query_from_submap = Rigid2{0, {x_m, 0}}.Inverse().ToRigid3();
  return candidate;
}

std::size_t NumLoops(std::vector<ScanLoopCandidate> candidates) {
  const Drive drive;
  DropDoubtfulLoops({}, drive.keyscans, DriftSums(drive.keyscans, drive.edges), &candidates);
  return static_cast<std::size_t>(std::ranges::count_if(candidates, &ScanLoopCandidate::is_loop));
}

TEST(DoubtfulLoops, SubmapsThatAgreeKeepTheirLoops) {
  EXPECT_EQ(NumLoops({Found(1, 4, 0.6), Found(2, 2, 0.95), Found(3, 0.3, 0.8)}), 3U);
  EXPECT_EQ(NumLoops({Found(1, 4, 0.6)}), 1U);
  EXPECT_EQ(NumLoops({}), 0U);
}

TEST(DoubtfulLoops, ABetterPlaceElsewhereIsBelieved) {
  EXPECT_EQ(NumLoops({Found(1, 6, 0.6), Found(2, 2, 0.95)}), 1U);
  // Nearly as good is not better: pose_graph decides.
  EXPECT_EQ(NumLoops({Found(1, 6, 0.9), Found(2, 2, 0.95)}), 2U);
}

TEST(DoubtfulLoops, SeveralPlacesOfAnotherSubmapAreADoubt) {
  EXPECT_EQ(NumLoops({Found(1, 4, 0.8), Found(2, 2, 0.78, 0.75)}), 0U);
  // Those that score less say nothing, nor does a submap that finds the query nowhere.
  EXPECT_EQ(NumLoops({Found(1, 4, 0.8), Found(2, 2, 0.6, 0.58)}), 1U);
  EXPECT_EQ(NumLoops({Found(1, 4, 0.8), Found(2, 0, 0)}), 1U);
}

TEST(DoubtfulLoops, OtherQueriesDoNotMatter) {
  ScanLoopCandidate other = Found(2, 2, 0.95, 0.9);
  other.query_keyscan = 16;
  EXPECT_EQ(NumLoops({Found(1, 4, 0.8), other}), 1U);
}

}  // namespace nightmap::doubtful_loops_test
