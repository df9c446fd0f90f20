// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/scan_adjust.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/recording/choose_signal.h"
#include "pipeline/recording/keyscans.h"
#include "stages/laser/scan_adjust/compare_scans.h"
#include "stages/laser/scan_adjust/keyscan_system.h"
#include "stages/laser/scan_adjust/scan_pairs.h"

namespace nightmap {
namespace {

constexpr double kSpacing_m = 0.05;  // distance of the points used on a wall
constexpr double kSmallStep = 2e-4;  // metres and radians that end the rounds

std::vector<std::vector<WallPoint>> WallsOf(const ScanAdjustOptions& options,
                                            const Signal& scans,
                                            const std::vector<StampedPose>& keyscans) {
  std::vector<std::vector<WallPoint>> walls;
  for (std::size_t i = 0; i < keyscans.size(); ++i) {
    walls.push_back(
        FindWallPoints(PointsOfKeyscan(scans, keyscans, i, options.max_range_m), kSpacing_m));
    walls.back().shrink_to_fit();
  }
  return walls;
}

class Adjuster {
 public:
  Adjuster(const ScanAdjustOptions& options,
           std::vector<std::vector<WallPoint>> walls,
           std::vector<Rigid2> poses,
           const std::vector<SensorEdge>& odometry)
      : options_(options),
        walls_(std::move(walls)),
        poses_(std::move(poses)),
        odometry_(odometry),
        pairs_(ChoosePairs(options, poses_)),
        system_(poses_.size(), LinkedKeyscans()) {}

  void Run(Progress& progress, int num_threads, ScanAdjustResult* result) {
    result->num_pairs = pairs_.size();
    progress.Start(static_cast<std::size_t>(options_.num_rounds) + 1);
    for (int round = 0; round < options_.num_rounds; ++round) {
      const double moved = Solve(Gate_m(round), num_threads);
      progress.Advance();
      if (moved < kSmallStep && Gate_m(round) <= options_.last_gate_m) break;
    }
    Judge(num_threads, result);
    progress.Advance();
  }

  const std::vector<Rigid2>& Poses() const { return poses_; }

 private:
  std::vector<std::pair<std::size_t, std::size_t>> LinkedKeyscans() const {
    std::vector<std::pair<std::size_t, std::size_t>> linked;
    for (const ScanPair& pair : pairs_) linked.emplace_back(pair.scan, pair.target);
    for (std::size_t i = 0; i < odometry_.size(); ++i) linked.emplace_back(i, i + 1);
    return linked;
  }

  // The gate narrows from the first to the last in equal ratios, over the first half of the rounds.
  double Gate_m(int round) const {
    const double part = std::min(1.0, round / std::max(1.0, options_.num_rounds / 2.0));
    return options_.first_gate_m * std::pow(options_.last_gate_m / options_.first_gate_m, part);
  }

  // Calls visit(pair, equations) for all pairs in order. Equations of few pairs are in memory.
  template <typename Visit>
  void Compare(double gate_m, int num_threads, const Visit& visit) const {
    constexpr std::size_t kNumAtOnce = 8192;
    std::vector<PairEquations> equations;
    for (std::size_t first = 0; first < pairs_.size(); first += kNumAtOnce) {
      equations.assign(std::min(kNumAtOnce, pairs_.size() - first), {});
      ParallelFor(equations.size(), num_threads, [&](std::size_t i) {
        const auto& [scan, target] = pairs_[first + i];
        equations[i] = CompareScans(
            walls_[scan], poses_[scan], walls_[target], poses_[target], gate_m, options_.sigma_m);
      });
      for (std::size_t i = 0; i < equations.size(); ++i) visit(pairs_[first + i], equations[i]);
    }
  }

  // The largest change of a pose.
  double Solve(double gate_m, int num_threads) {
    system_.Clear();
    Compare(gate_m, num_threads, [&](const ScanPair& pair, const PairEquations& equations) {
      system_.Add(pair.scan, pair.target, equations.hessian, equations.gradient);
    });
    for (std::size_t i = 0; i < odometry_.size(); ++i) AddOdometry(i);
    const Eigen::VectorXd step = system_.Step();
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      const auto first = 3 * static_cast<Eigen::Index>(i);
      poses_[i].translation += step.segment<2>(first);
      poses_[i].heading_rad = WrapAngle_rad(poses_[i].heading_rad + step[first + 2]);
    }
    return step.cwiseAbs().maxCoeff();
  }

  // The motion from keyscan i to the next one.
  void AddOdometry(std::size_t i) {
    const Rigid2 &a = poses_[i], &b = poses_[i + 1];
    const Rigid2 a_from_b = ToRigid2(odometry_[i].target_from_source).Inverse();
    const Eigen::Matrix2d b_from_graph = Eigen::Rotation2Dd(-b.heading_rad).matrix();
    const Eigen::Vector2d step = Eigen::Rotation2Dd(a.heading_rad) * a_from_b.translation;
    Eigen::Matrix<double, 3, 6> derivatives = Eigen::Matrix<double, 3, 6>::Zero();
    derivatives.block<2, 2>(0, 0) = -b_from_graph;
    derivatives.block<2, 1>(0, 2) = -b_from_graph * Eigen::Vector2d(-step.y(), step.x());
    derivatives.block<2, 2>(0, 3) = b_from_graph;
    derivatives(2, 2) = -1;
    derivatives(2, 5) = 1;
    Eigen::Vector3d error;
    error << b_from_graph * (b.translation - a.translation - step),
        WrapAngle_rad(b.heading_rad - a.heading_rad - a_from_b.heading_rad);
    constexpr int kRows[] = {3, 4, 2};  // of x, y and heading
    Eigen::Matrix3d covariance;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        covariance(row, column) = odometry_[i].covariance(kRows[row], kRows[column]);
      }
    }
    const Eigen::Matrix3d information = covariance.inverse();
    system_.Add(i,
                i + 1,
                derivatives.transpose() * information * derivatives,
                derivatives.transpose() * information * error);
  }

  // How far the points that match at the end are from the walls.
  void Judge(int num_threads, ScanAdjustResult* result) const {
    double sum_m2 = 0;
    Compare(options_.last_gate_m, num_threads, [&](const ScanPair&, const PairEquations& pair) {
      result->num_matches += pair.num_matches;
      sum_m2 += pair.sum_squares_m2;
    });
    result->rms_m =
        std::sqrt(sum_m2 / std::max<double>(1, static_cast<double>(result->num_matches)));
  }

  const ScanAdjustOptions& options_;
  std::vector<std::vector<WallPoint>> walls_;
  std::vector<Rigid2> poses_;  // graph_from_robot
  const std::vector<SensorEdge>& odometry_;
  std::vector<ScanPair> pairs_;
  KeyscanSystem system_;
};

}  // namespace

ScanAdjustResult RunScanAdjust(const ScanAdjustOptions& options,
                               ScanAdjustInput input,
                               Progress& progress,
                               int num_threads) {
  const Signal& scans = ChooseScanner(input.scans, options.scan_sensor, "scan_adjust.scan_sensor");
  CheckEdgesOfKeyscans(input.keyscans, input.odometry.edges);
  std::vector<Rigid2> poses;
  for (const StampedPose& keyscan : input.keyscans) poses.push_back(ToRigid2(keyscan.pose));
  auto walls = WallsOf(options, scans, input.keyscans);
  input.scans = {};  // the walls stand for them
  Adjuster adjuster(options, std::move(walls), std::move(poses), input.odometry.edges);
  ScanAdjustResult result;
  adjuster.Run(progress, num_threads, &result);
  for (std::size_t i = 0; i < input.keyscans.size(); ++i) {
    result.keyscans.push_back({input.keyscans[i].time_ns, adjuster.Poses()[i].ToRigid3()});
  }
  return result;
}

}  // namespace nightmap
