// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_adjust/ceiling_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"
#include "stages/ceiling/ceiling_adjust/ceiling_errors.h"
#include "stages/ceiling/ceiling_adjust/ceiling_system.h"
#include "stages/ceiling/ceiling_adjust/keyframe_tree.h"

namespace nightmap {
namespace {

constexpr double kSightingLoss = 1.5;  // in standard deviations, as the next
// A loop moves a long way: sightings that are so far off pull like others until it has moved.
constexpr double kFirstSightingLoss = 100;
// Decrease of the cost, as a share of it, from which it is at its minimum: what is left then is of
// corners whose place no picture tells.
constexpr double kFirstTolerance = 1e-2, kTolerance = 1e-5;
// Damping of a keyframe's own curvature by more than this holds the long waves of a long way,
// which are all but flat, where they are.
constexpr double kMinDamping = 1e-13;
constexpr double kMaxDamping = 1e3;
constexpr double kRounding = 1e-9;  // of the cost
constexpr double kNoCost = 1e-12;   // per sighting: rounding
constexpr int kMaxSteps = 50;       // under one loss
constexpr double kMaxLength = 64;   // of a step, as a multiple of the one that was found

IndexGroups ByPoint(const CeilingProblem& problem, std::size_t num_points) {
  std::vector<int> points;
  points.reserve(problem.sightings.size());
  for (const PointSighting& sighting : problem.sightings) {
    points.push_back(SparseIndex(sighting.point));
  }
  return {points, num_points};
}

class Solver {
 public:
  Solver(const CeilingNoise& noise, const CeilingProblem& problem, CeilingUnknowns* unknowns)
      : noise_(noise),
        problem_(problem),
        unknowns_(*unknowns),
        of_point_(ByPoint(problem, unknowns->points.size())),
        neighbours_(FindNeighbours(problem, of_point_, unknowns->keyframes.size())),
        tree_(neighbours_, problem, of_point_, unknowns->points.size()),
        system_(noise, problem, of_point_, neighbours_, unknowns->points.size()) {}

  // First with a loss that few sightings feel, then with the one that outliers do.
  CeilingSolution Solve(Progress& progress) {
    progress.Start(2 * kMaxSteps);
    CeilingSolution solution;
    solution.initial_cost = Cost(unknowns_, CauchyLoss{kFirstSightingLoss});
    if (!std::isfinite(solution.initial_cost)) Fail("a landmark is not above its camera");
    Solve(CauchyLoss{kFirstSightingLoss}, kFirstTolerance, progress, &solution);
    Solve(CauchyLoss{kSightingLoss}, kTolerance, progress, &solution);
    solution.median_error_px = MedianError_px();
    progress.Finish();
    return solution;
  }

 private:
  void Solve(const CauchyLoss& loss,
             double tolerance,
             Progress& progress,
             CeilingSolution* solution) {
    double cost = Cost(unknowns_, loss);
    solution->has_converged = false;
    for (int i = 0; i < kMaxSteps && !solution->has_converged; ++i) {
      const double gain = TakeStep(loss, cost);
      solution->has_converged = gain <= tolerance * cost + NoCost();
      cost -= gain;
      ++solution->num_iterations;
      progress.Advance();
    }
    solution->final_cost = cost;
  }

  double NoCost() const { return kNoCost * static_cast<double>(problem_.sightings.size()); }

  struct Trial {
    CeilingUnknowns unknowns;
    double cost;
  };

  Trial Try(const CauchyLoss& loss, const CeilingStep& step, double length) const {
    Trial trial{tree_.Moved(unknowns_, step, length), 0};
    trial.cost = Cost(trial.unknowns, loss);
    return trial;
  }

  // Takes the least damped step that lowers the cost; returns by how much. 0: none is expected to
  // lower it by more than rounding does.
  double TakeStep(const CauchyLoss& loss, double cost) {
    for (; damping_ < kMaxDamping; damping_ *= 100) {
      const auto step = system_.Step(unknowns_, loss, damping_);
      if (!step) continue;
      Trial best = Try(loss, *step, 1);
      if (best.cost < cost) {
        Lengthen(loss, *step, &best);
        unknowns_ = std::move(best.unknowns);
        damping_ = std::max(kMinDamping, damping_ / 100);
        return cost - best.cost;
      }
      if (step->expected_gain <= kRounding * cost + NoCost()) return 0;
    }
    Fail("no step lowers its cost");
  }

  // Weights are as if errors kept them, but an outlier's falls on the way, and with it what holds
  // the others back: a longer step often lowers the cost more, and costs no factorization.
  void Lengthen(const CauchyLoss& loss, const CeilingStep& step, Trial* best) const {
    for (double length = 2; length <= kMaxLength; length *= 2) {
      Trial longer = Try(loss, step, length);
      if (!(longer.cost < best->cost)) return;
      *best = std::move(longer);
    }
  }

  // Infinite where a point is not in front of a camera that saw it.
  double Cost(const CeilingUnknowns& unknowns, const CauchyLoss& loss) const {
    const std::vector<KeyframeView> views = ViewsOf(problem_, unknowns);
    const double per_sigma = 1 / noise_.pixel_sigma_px;
    double cost = ExpectedCommon(noise_, problem_, unknowns).Cost();
    for (const PointSighting& sighting : problem_.sightings) {
      const auto error_px =
          views[sighting.keyframe].Error_px(unknowns.points[sighting.point], sighting.pixel);
      if (!error_px) return std::numeric_limits<double>::infinity();
      cost += loss.Cost((*error_px * per_sigma).squaredNorm());
    }
    for (const KeyframeMotion& motion : problem_.motions) {
      const LinearMotion linear = LinearizeMotion(noise_,
                                                  motion,
                                                  unknowns.keyframes[motion.start].head<3>(),
                                                  unknowns.keyframes[motion.start + 1].head<3>(),
                                                  unknowns.wheels);
      cost += kWheelLoss.Cost(linear.residual.squaredNorm());
    }
    for (const Vector5d& keyframe : unknowns.keyframes) {
      cost += ExpectedTilt(noise_, keyframe).Cost();
    }
    if (!problem_.level) return cost;
    for (const std::size_t point : problem_.level->points) {
      const double error = (unknowns.points[point].z() - unknowns.level_m) / kLevelSigma_m;
      cost += kLevelLoss.Cost(error * error);
    }
    return cost;
  }

  double MedianError_px() const {
    const std::vector<KeyframeView> views = ViewsOf(problem_, unknowns_);
    std::vector<double> errors_px;
    for (const PointSighting& sighting : problem_.sightings) {
      const auto error_px =
          views[sighting.keyframe].Error_px(unknowns_.points[sighting.point], sighting.pixel);
      if (error_px) errors_px.push_back(error_px->norm());
    }
    return Median(std::move(errors_px));
  }

  [[noreturn]] void Fail(const char* reason) const {
    throw DataError("the ceiling of {} keyframes and {} landmarks was not adjusted: {}",
                    unknowns_.keyframes.size(),
                    unknowns_.points.size(),
                    reason);
  }

  const CeilingNoise& noise_;
  const CeilingProblem& problem_;
  CeilingUnknowns& unknowns_;
  IndexGroups of_point_;
  std::vector<std::vector<int>> neighbours_;  // by keyframe
  KeyframeTree tree_;
  CeilingSystem system_;
  double damping_ = kMinDamping;  // of the next step
};

}  // namespace

CeilingSolution SolveCeiling(const CeilingNoise& noise,
                             const CeilingProblem& problem,
                             Progress& progress,
                             CeilingUnknowns* unknowns) {
  return Solver(noise, problem, unknowns).Solve(progress);
}

}  // namespace nightmap
