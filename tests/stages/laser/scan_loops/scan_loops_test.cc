// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/scan_loops.h"

#include <Eigen/Cholesky>

#include "pipeline/base/input_error.h"
#include "tests/laser_building.h"
#include "tests/test_data.h"

namespace nightmap::scan_loops_test {

constexpr double kDegree_rad = std::numbers::pi / 180;

// A corridor of 2.5 m around a block with rooms of different sizes, and cupboards on its outer
// walls.
const Building kRing{{{-10, -7}, {10, 7}},
                     {{-7.5, -4.5}, {-5, 4.5}},
                     {{-5, -1}, {7.5, 0.5}},
                     {{-3.5, -4.5}, {-1, -4.3}},
                     {{-1.2, -4.3}, {-1, -1}},
                     {{0.8, -4.5}, {5.2, -4.3}},
                     {{5.2, -4.5}, {5.4, -1}},
                     {{6.6, -4.5}, {7.5, -4.3}},
                     {{7.3, -4.3}, {7.5, -2.6}},
                     {{7.3, -1.4}, {7.5, 4.5}},
                     {{-5, 4.3}, {-0.4, 4.5}},
                     {{0.9, 4.3}, {3, 4.5}},
                     {{2.8, 0.5}, {3, 4.3}},
                     {{4.5, 4.3}, {7.3, 4.5}},
                     {{-10, -2}, {-9.5, -0.7}},
                     {{-6.3, 6.6}, {-4, 7}},
                     {{9.6, 1.5}, {10, 4}},
                     {{3.1, -7}, {3.9, -6.5}}};

std::vector<Rigid2> AroundTheRing(double num_laps) {
  return DriveAround({8.75, 5.75}, 1, 0.3, num_laps);
}
constexpr double kLap_m = 2 * (17.5 + 11.5) - 8 + 2 * std::numbers::pi;

// A true drive, and what it looks like by odometry that drifts evenly.
struct Drive {
  std::vector<Rigid2> truth;
  ScanLoopsInput input;

  // `drift`: of the start's frame after drift_path_m.
  Drive(const Building& building,
        std::vector<Rigid2> poses,
        const Rigid2& drift,
        double drift_path_m)
      : truth(std::move(poses)) {
    std::vector<Rigid2> drifted;
    double path_m = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (i > 0) path_m += (truth[i].translation - truth[i - 1].translation).norm();
      const double part = path_m / drift_path_m;
      drifted.push_back(Rigid2{part * drift.heading_rad, part * drift.translation} *
                        (truth[0].Inverse() * truth[i]));
    }
    const double num_edges = drift_path_m / (path_m / static_cast<double>(truth.size()));
    input.scans = {ScansAt(building, truth, 0.02)};
    input.keyscans = KeyscansAt(drifted);
    input.odometry = OdometryOf(drifted,
                                drift.translation.norm() / std::sqrt(num_edges),
                                std::abs(drift.heading_rad) / std::sqrt(num_edges));
  }

  // Error of the pose of a loop's query seen from its submap.
  Rigid2 ErrorOf(const ScanLoopCandidate& loop) const {
    const Rigid2 true_query_from_submap =
        truth[loop.query_keyscan].Inverse() * truth[loop.submap_keyscan];
    return true_query_from_submap.Inverse() * ToRigid2(loop.query_from_submap);
  }
};

Drive DriftingDrive(double num_laps = 1.4) {
  return {kRing, AroundTheRing(num_laps), {5 * kDegree_rad, {0.5, -0.62}}, kLap_m};
}

ScanLoopsResult Find(const ScanLoopsInput& input,
                     const ScanLoopsOptions& options = {},
                     int num_threads = 2) {
  Progress progress("scan_loops", false);
  return RunScanLoops(options, input, progress, num_threads);
}

std::vector<ScanLoopCandidate> LoopsOf(const ScanLoopsResult& result) {
  std::vector<ScanLoopCandidate> loops;
  for (const ScanLoopCandidate& candidate : result.candidates) {
    if (candidate.is_loop) loops.push_back(candidate);
  }
  return loops;
}

TEST(ScanLoops, ARingIsClosedAgainstADriftOfMostOfAMetre) {
  const Drive drive = DriftingDrive();
  const ScanLoopsResult result = Find(drive.input);
  const std::vector<ScanLoopCandidate> loops = LoopsOf(result);
  // 0.4 laps of 56 m, a query each metre.
  EXPECT_GT(loops.size(), 15U);
  int num_of_lap = 0;
  for (const ScanLoopCandidate& loop : loops) {
    SCOPED_TRACE(testing::Message() << loop.submap_keyscan << " to " << loop.query_keyscan);
    const Rigid2 error = drive.ErrorOf(loop);
    EXPECT_LT(error.translation.norm(), 0.03);
    EXPECT_LT(std::abs(error.heading_rad), 0.5 * kDegree_rad);
    EXPECT_GE(loop.score, 0.55);
    num_of_lap += 0.3 * static_cast<double>(loop.query_keyscan - loop.submap_keyscan) > 50;
  }
  EXPECT_GT(num_of_lap, 15);
}

TEST(ScanLoops, AnEdgeIsALoopWithItsTimesAndItsCovariance) {
  const Drive drive = DriftingDrive(1.2);
  const ScanLoopsResult result = Find(drive.input);
  const std::vector<ScanLoopCandidate> loops = LoopsOf(result);
  ASSERT_GT(loops.size(), 5U);
  ASSERT_EQ(result.edges.edges.size(), loops.size());
  EXPECT_EQ(result.edges.sensor, "laser");
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const SensorEdge& edge = result.edges.edges[i];
    EXPECT_EQ(edge.kind, EdgeKind::kLoop);
    EXPECT_EQ(edge.source_time_ns, drive.input.keyscans[loops[i].submap_keyscan].time_ns);
    EXPECT_EQ(edge.target_time_ns, drive.input.keyscans[loops[i].query_keyscan].time_ns);
    EXPECT_LT(edge.source_time_ns, edge.target_time_ns);
    EXPECT_EQ(edge.target_from_source.Matrix(), loops[i].query_from_submap.Matrix());
    EXPECT_TRUE(edge.covariance.isApprox(edge.covariance.transpose(), 1e-9));
    EXPECT_EQ(Eigen::LLT<Matrix6d>(edge.covariance).info(), Eigen::Success);
    EXPECT_LT(edge.covariance.block(3, 3, 2, 2).trace(), 0.1 * 0.1);
  }
  const TemporaryFolder folder;
  WriteEdges(folder / "e.h5", result.edges, "x = 1\n");
  const SensorEdges read = ReadEdges(folder / "e.h5");
  ASSERT_EQ(read.edges.size(), loops.size());
  EXPECT_EQ(read.edges[0].covariance, result.edges.edges[0].covariance);
  WriteEdges(folder / "again.h5", read, "x = 1\n");
  EXPECT_EQ(ReadBytes(folder / "again.h5"), ReadBytes(folder / "e.h5"));
}

TEST(ScanLoops, AnyNumberOfThreadsFindsTheSame) {
  const Drive drive = DriftingDrive(1.2);
  const TemporaryFolder folder;
  WriteEdges(folder / "1.h5", Find(drive.input, {}, 1).edges, "");
  WriteEdges(folder / "4.h5", Find(drive.input, {}, 4).edges, "");
  EXPECT_EQ(ReadBytes(folder / "1.h5"), ReadBytes(folder / "4.h5"));
}

constexpr double kOtherPlace_m = 0.25;  // 6 m of a submap drift by 0.2 m

// Forth along a corridor of 40 m, whose ends are out of sight; back without a turn, since the
// scanner looks all around.
std::vector<Rigid2> AlongACorridor(bool is_back_again) {
  std::vector<Rigid2> poses;
  for (int i = 0; i <= 80; ++i) poses.push_back({0, {-12 + 0.3 * i, 0.1}});
  for (int i = 79; is_back_again && i >= 0; --i) poses.push_back({0, {-12 + 0.3 * i, -0.1}});
  return poses;
}

// Pillars on both sides: each 2 m, or at places of their own.
Building Corridor(bool is_periodic) {
  Building corridor{{{-20, -1.5}, {20, 1.5}}};
  Random random(3);
  for (double x_m = -19; x_m < 19; x_m += is_periodic ? 2 : random.Uniform(0.8, 3)) {
    const double width_m = is_periodic ? 0.4 : random.Uniform(0.2, 0.6);
    corridor.push_back({{x_m, 1.1}, {x_m + width_m, 1.5}});
    if (is_periodic || random.Uniform() < 0.5) {
      corridor.push_back({{x_m, -1.5}, {x_m + width_m, -1.1}});
    }
  }
  return corridor;
}

// The view ahead does not tell places apart; a submap is larger than what a query sees, by more
// than a place that looks alike.
ScanLoopsOptions NearSighted() {
  ScanLoopsOptions options;
  options.max_range_m = 6;
  options.submap_length_m = 12;
  options.max_candidates = 1;
  return options;
}

// Where the submap shows several of them; that of a query at its rim may show one alone.
TEST(ScanLoops, PlacesThatLookAlikeWithinTheDriftAreNoLoop) {
  const Drive drive(Corridor(true), AlongACorridor(true), {0.01, {1.3, 0.05}}, 40);
  const auto num_wrong = [&](double max_second_ratio) {
    ScanLoopsOptions options = NearSighted();
    options.max_second_ratio = max_second_ratio;
    int num = 0;
    for (const ScanLoopCandidate& loop : LoopsOf(Find(drive.input, options))) {
      const Eigen::Vector2d apart = drive.truth[loop.query_keyscan].translation -
                                    drive.truth[loop.submap_keyscan].translation;
      const bool is_amid = apart.norm() < 4;
      num += is_amid && drive.ErrorOf(loop).translation.norm() > kOtherPlace_m;
    }
    return num;
  };
  EXPECT_EQ(num_wrong(ScanLoopsOptions{}.max_second_ratio), 0);
  EXPECT_GT(num_wrong(1), 3);
}

TEST(ScanLoops, PlacesThatLookDifferentAreLoops) {
  const Drive drive(Corridor(false), AlongACorridor(true), {0.01, {1.3, 0.05}}, 40);
  const auto loops = LoopsOf(Find(drive.input, NearSighted()));
  EXPECT_GT(loops.size(), 10U);
  for (const ScanLoopCandidate& loop : loops) {
    EXPECT_LT(drive.ErrorOf(loop).translation.norm(), kOtherPlace_m);
  }
}

TEST(ScanLoops, WithoutARevisitThereIsNone) {
  const Drive drive(Corridor(false), AlongACorridor(false), {0.01, {1.3, 0.05}}, 40);
  const ScanLoopsResult result = Find(drive.input, NearSighted());
  EXPECT_GT(result.num_submaps, 3U);
  EXPECT_GT(result.num_queries, 15U);
  EXPECT_TRUE(result.edges.edges.empty());
}

TEST(ScanLoops, ALowScoreIsNoLoop) {
  const Drive drive = DriftingDrive(1.1);
  ScanLoopsOptions options;
  options.min_score = 0.999;
  const ScanLoopsResult result = Find(drive.input, options);
  EXPECT_FALSE(result.candidates.empty());
  EXPECT_TRUE(result.edges.edges.empty());
}

TEST(ScanLoops, ASingleKeyscanHasNoLoops) {
  Drive drive = DriftingDrive(0.3);
  drive.input.keyscans.resize(1);
  drive.input.odometry.edges.clear();
  const ScanLoopsResult result = Find(drive.input);
  EXPECT_EQ(result.num_submaps, 1U);
  EXPECT_TRUE(result.candidates.empty());
}

TEST(ScanLoops, InputsThatDoNotFitAreRefused) {
  const ScanLoopsInput good = DriftingDrive(0.3).input;
  ScanLoopsInput input = good;
  input.odometry.edges.pop_back();
  NIGHTMAP_EXPECT_ERROR(InputError, Find(input), "odometry, keyframes: their keyscans differ");
  input = good;
  input.odometry.edges[3].target_time_ns += 1;
  NIGHTMAP_EXPECT_ERROR(InputError, Find(input), "their keyscans differ");
  input = good;
  input.scans[0].samples.erase(input.scans[0].samples.begin() + 5);
  NIGHTMAP_EXPECT_ERROR(InputError, Find(input), "there is a keyscan and no scan at 5.0");
  input = good;
  input.scans.clear();
  NIGHTMAP_EXPECT_ERROR(InputError, Find(input), "no sensor of the site scans");
  input = good;
  input.scans.push_back(good.scans[0]);
  input.scans[1].sensor_id = "rear";
  NIGHTMAP_EXPECT_ERROR(
      UsageError, Find(input), "scan_loops.scan_sensor is '': choose one of the sensors");
}

}  // namespace nightmap::scan_loops_test
