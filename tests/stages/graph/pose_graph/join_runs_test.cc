// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/join_runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "stages/graph/pose_graph/drift_gate.h"
#include "tests/stages/graph/pose_graph/noisy_path.h"

namespace nightmap::join_runs_test {

constexpr double kMaxDrift = 10;

// Tracking is lost before frames 30 and 60, and where it goes on nobody knows.
std::vector<PoseEdge> BrokenDrive() {
  std::vector<PoseEdge> edges = Drive(90, 3);
  for (const std::size_t lost : {29U, 59U}) {
    edges[lost].is_bridge = true;
    edges[lost].b_from_a.translation += Eigen::Vector3d(20, -7, 3);
    edges[lost].covariance = 1e4 * Matrix6d::Identity();
  }
  return edges;
}

PoseEdge WrongLoop(int a, int b, const Eigen::Vector3d& offset) {
  PoseEdge loop = TrueLoop(a, b);
  loop.b_from_a.translation += offset;
  return loop;
}

double Error_m(const std::vector<PoseEdge>& tree, int a, int b) {
  const auto poses = DriftGate(tree).Poses();
  return (poses.at(b).Inverse() * poses.at(a) * TrueLoop(a, b).b_from_a.Inverse())
      .translation.norm();
}

TEST(JoinRuns, PutsRunsWhereMostLoopsWantThem) {
  std::vector<PoseEdge> loops;
  for (const int i : {0, 5, 10}) {
    loops.push_back(WrongLoop(i, 40 + i, {5, 0, 0}));  // agree with each other, but are fewer
  }
  for (const int i : {0, 4, 8, 12}) loops.push_back(TrueLoop(i, 35 + i));
  for (const int i : {30, 33, 36}) loops.push_back(TrueLoop(i, 40 + i));
  const auto tree = JoinRuns(BrokenDrive(), loops, kMaxDrift);
  EXPECT_EQ(tree.size(), 89U);
  EXPECT_EQ(std::ranges::count_if(tree, &PoseEdge::is_bridge), 0);
  EXPECT_LT(Error_m(tree, 3, 45), 1.5);  // the drift of some 40 steps
  EXPECT_LT(Error_m(tree, 3, 80), 3);
}

TEST(JoinRuns, TwoLoopsAreNotEnough) {
  const auto odometry = BrokenDrive();
  const auto tree = JoinRuns(odometry, {TrueLoop(0, 40), TrueLoop(5, 45)}, kMaxDrift);
  EXPECT_EQ(std::ranges::count_if(tree, &PoseEdge::is_bridge), 2);
  const auto poses = DriftGate(tree).Poses();
  const auto by_odometry = DriftGate(odometry).Poses();
  for (const auto& [idx, pose] : by_odometry) {
    EXPECT_EQ(pose.translation, poses.at(idx).translation);
  }
}

// The run in the middle has no loop; it stays where its bridge puts it while the last one is
// joined.
TEST(JoinRuns, ARunWithoutLoopsHangsOnItsBridge) {
  const auto tree =
      JoinRuns(BrokenDrive(), {TrueLoop(0, 70), TrueLoop(5, 75), TrueLoop(10, 80)}, kMaxDrift);
  EXPECT_EQ(std::ranges::count_if(tree, &PoseEdge::is_bridge), 1);
  EXPECT_LT(Error_m(tree, 3, 80), 1.5);
  EXPECT_GT(Error_m(tree, 3, 45), 10);
}

TEST(JoinRuns, WithoutBridgesNothingChanges) {
  const auto odometry = Drive(20, 1);
  const auto tree = JoinRuns(odometry, {TrueLoop(0, 19)}, kMaxDrift);
  ASSERT_EQ(tree.size(), odometry.size());
  for (std::size_t i = 0; i < tree.size(); ++i) EXPECT_EQ(tree[i].frame_b, odometry[i].frame_b);
}

// A drive over one path many times: place p of lap k is frame k * kLap + p.
constexpr int kLap = 60;

PoseEdge Revisit(int a, int b, Random& random) {
  const int place_a = a % kLap;
  const int place_b = b % kLap;
  PoseEdge loop = TrueLoop(std::min(place_a, place_b), std::max(place_a, place_b));
  if (place_a > place_b) loop.b_from_a = loop.b_from_a.Inverse();
  loop.frame_a = a;
  loop.frame_b = b;
  loop.b_from_a = DrawNoise(random) * loop.b_from_a;
  loop.covariance = StepCovariance();
  return loop;
}

// Laps begin with a bridge; some are cut in two by another. Loops join a lap to the next two;
// every eighth is wrong.
struct Laps {
  explicit Laps(int num_laps, int num_loops, std::uint64_t seed) : random(seed) {
    for (int lap = 0; lap < num_laps; ++lap) AddLap(lap);
    const auto num_frames = static_cast<std::size_t>(num_laps * kLap);
    while (static_cast<int>(loops.size()) < num_loops) {
      const int a = static_cast<int>(random.Index(num_frames));
      const int b = a + (1 + static_cast<int>(random.Index(2))) * kLap +
                    static_cast<int>(random.Index(11)) - 5;
      if (static_cast<std::size_t>(b) >= num_frames || b / kLap == a / kLap) continue;
      if (std::abs(a % kLap - b % kLap) > 5) continue;  // b is in the lap beside
      loops.push_back(Revisit(a, b, random));
      if (loops.size() % 8 == 0) loops.back().b_from_a.translation.y() += 3 * random.Gaussian();
    }
  }

  void AddLap(int lap) {
    for (PoseEdge edge : Drive(kLap, random.Index(1000))) {
      edge.frame_a += lap * kLap;
      edge.frame_b += lap * kLap;
      edge.is_bridge = lap % 3 == 0 && edge.frame_b % kLap == 40;
      odometry.push_back(edge);
    }
    PoseEdge bridge{lap * kLap - 1, lap * kLap, {}, 1e4 * Matrix6d::Identity(), true};
    if (lap > 0) odometry.insert(odometry.end() - (kLap - 1), bridge);
  }

  Random random;
  std::vector<PoseEdge> odometry, loops;
};

// Sets of joined keyframes, by a gate of the tree so far.
bool AreJoined(const std::vector<PoseEdge>& tree, const PoseEdge& edge) {
  return std::isfinite(DriftGate(tree, {edge}).Distance(edge));
}

// Builds a gate anew for each hypothesis.
class NaiveJoiner {
 public:
  std::vector<PoseEdge> Join(const Laps& laps) {
    for (const PoseEdge& edge : laps.odometry) {
      if (!edge.is_bridge) tree_.push_back(edge);
    }
    while (JoinBest(laps.loops)) {
    }
    for (const PoseEdge& edge : laps.odometry) {
      if (edge.is_bridge && !AreJoined(tree_, edge)) tree_.push_back(edge);
    }
    return tree_;
  }

 private:
  bool JoinBest(const std::vector<PoseEdge>& loops) {
    std::vector<PoseEdge> open;
    for (const PoseEdge& loop : loops) {
      if (!AreJoined(tree_, loop)) open.push_back(loop);
    }
    std::ptrdiff_t best_support = 2;
    const PoseEdge* best = nullptr;
    for (std::size_t i = 0; i < open.size(); i += open.size() / 100 + 1) {
      const auto support = Support(open[i], open);
      if (support > best_support) best = &open[i];
      best_support = std::max(best_support, support);
    }
    if (best) tree_.push_back(*best);
    return best != nullptr;
  }

  // A loop that the hypothesis does not join is infinitely far.
  std::ptrdiff_t Support(const PoseEdge& hypothesis, const std::vector<PoseEdge>& open) const {
    std::vector<PoseEdge> joined = tree_;
    joined.push_back(hypothesis);
    const DriftGate gate(joined, open);
    return std::ranges::count_if(
        open, [&](const PoseEdge& loop) { return gate.Distance(loop) <= kMaxDrift; });
  }

  std::vector<PoseEdge> tree_;
};

TEST(JoinRuns, JoinsByTheLoopsThatANaiveSearchChooses) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const Laps laps(5, 150, seed);
    const auto tree = JoinRuns(laps.odometry, laps.loops, kMaxDrift);
    const auto naive = NaiveJoiner().Join(laps);
    ASSERT_EQ(tree.size(), naive.size());
    for (std::size_t i = 0; i < tree.size(); ++i) {
      EXPECT_EQ(std::pair(tree[i].frame_a, tree[i].frame_b),
                std::pair(naive[i].frame_a, naive[i].frame_b));
      EXPECT_EQ(tree[i].b_from_a.translation, naive[i].b_from_a.translation);
    }
    EXPECT_EQ(std::ranges::count_if(tree, &PoseEdge::is_bridge), 0);
  }
}

// Quadratic code would take hours.
TEST(JoinRuns, ANightOfManyRunsIsJoined) {
  const Laps laps(330, 20000, 4);
  const auto tree = JoinRuns(laps.odometry, laps.loops, kMaxDrift);
  EXPECT_EQ(tree.size(), static_cast<std::size_t>(330 * kLap - 1));
  EXPECT_EQ(std::ranges::count_if(tree, &PoseEdge::is_bridge), 0);
}

}  // namespace nightmap::join_runs_test
