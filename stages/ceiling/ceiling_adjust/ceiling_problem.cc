// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_adjust/ceiling_problem.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"
#include "stages/ceiling/ceiling_adjust/ceiling_residuals.h"

namespace nightmap {
namespace {

constexpr double kMountingSigma_m = 0.03;
constexpr double kSightingLoss = 1.5;  // in standard deviations, as the next
// A loop moves a long way: sightings that are so far off pull like others until it has moved.
constexpr double kFirstSightingLoss = 100;
constexpr double kWheelLoss = 3;
// Decrease of the cost, as a share of it, from which it is at its minimum: what is left then is of
// corners whose place no picture tells.
constexpr double kFirstTolerance = 1e-2, kTolerance = 1e-5;
// Damping of a keyframe's own curvature over less than this holds the long waves of a long way,
// which are all but flat, where they are.
constexpr double kFirstTrust = 1e10;
constexpr int kMaxIterations = 50;

class ShowIteration : public ceres::IterationCallback {
 public:
  explicit ShowIteration(Progress* progress) : progress_(progress) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    progress_->Advance();
    return ceres::SOLVER_CONTINUE;
  }

 private:
  Progress* progress_;
};

class Builder {
 public:
  Builder(const CeilingNoise& noise, const CeilingProblem& given, CeilingUnknowns* unknowns)
      : noise_(noise), given_(given), unknowns_(*unknowns) {}

  void AddSightings() {
    for (const PointSighting& sighting : given_.sightings) {
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<SightingError, 2, 5, 5, 3>(
              new SightingError(given_, sighting.pixel, noise_.pixel_sigma_px)),
          &sighting_loss_,
          unknowns_.keyframes[sighting.keyframe].data(),
          unknowns_.mounting.data(),
          unknowns_.points[sighting.point].data());
    }
  }

  void AddMotions() {
    for (const KeyframeMotion& motion : given_.motions) {
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<MotionError, 3, 5, 5, 2>(new MotionError(noise_, motion)),
          &wheel_loss_,
          unknowns_.keyframes[motion.start].data(),
          unknowns_.keyframes[motion.start + 1].data(),
          unknowns_.wheels.data());
    }
    problem_.AddResidualBlock(
        ExpectedValues<2, 0, 2>::Cost(Eigen::Vector2d::Zero(),
                                      {noise_.scale_sigma, noise_.heading_bias_sigma_rad_per_m}),
        nullptr,
        unknowns_.wheels.data());
  }

  void AddMounting() {
    const Eigen::Vector2d vibration = Eigen::Vector2d::Constant(noise_.vibration_sigma_rad);
    for (Vector5d& keyframe : unknowns_.keyframes) {
      problem_.AddResidualBlock(ExpectedValues<5, 3, 2>::Cost(Eigen::Vector2d::Zero(), vibration),
                                nullptr,
                                keyframe.data());
    }
    Vector5d sigma = Vector5d::Constant(noise_.mounting_tilt_sigma_rad);
    sigma.tail<2>().setConstant(kMountingSigma_m);
    problem_.AddResidualBlock(
        ExpectedValues<5, 0, 5>::Cost(Vector5d::Zero(), sigma), nullptr, unknowns_.mounting.data());
    problem_.SetManifold(unknowns_.keyframes.front().data(),
                         new ceres::SubsetManifold(5, {0, 1, 2}));
  }

  void AddLevel() {
    if (!given_.level) return;
    using Scalar = Eigen::Matrix<double, 1, 1>;
    problem_.AddResidualBlock(ExpectedValues<1, 0, 1>::Cost(Scalar(given_.level->height_m),
                                                            Scalar(given_.level->sigma_m)),
                              nullptr,
                              &unknowns_.level_m);
    for (const std::size_t point : given_.level->points) {
      problem_.AddResidualBlock(
          new ceres::AutoDiffCostFunction<LevelError, 1, 3, 1>(new LevelError),
          &level_loss_,
          unknowns_.points[point].data(),
          &unknowns_.level_m);
    }
  }

  // First with a loss that few sightings feel, then with the one that outliers do.
  ceres::Solver::Summary Solve(Progress& progress) {
    progress.Start(2 * (kMaxIterations + 1));  // the first one of each is the start
    sighting_loss_.Reset(new ceres::CauchyLoss(kFirstSightingLoss), ceres::TAKE_OWNERSHIP);
    ceres::Solver::Summary first = Solve(kFirstTolerance, progress);
    sighting_loss_.Reset(new ceres::CauchyLoss(kSightingLoss), ceres::TAKE_OWNERSHIP);
    ceres::Solver::Summary summary = Solve(kTolerance, progress);
    progress.Finish();
    first.iterations.pop_back();  // its end is where the second one starts
    summary.iterations.insert(
        summary.iterations.begin(), first.iterations.begin(), first.iterations.end());
    return summary;
  }

 private:
  static ceres::Problem::Options ProblemOptions() {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  ceres::Solver::Summary Solve(double tolerance, Progress& progress) {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    std::vector<double*> blocks;
    problem_.GetParameterBlocks(&blocks);
    for (double* block : blocks) options.linear_solver_ordering->AddElementToGroup(block, 1);
    for (auto& point : unknowns_.points) {
      if (problem_.HasParameterBlock(point.data())) {
        options.linear_solver_ordering->AddElementToGroup(point.data(), 0);
      }
    }
    options.max_num_iterations = kMaxIterations;
    options.function_tolerance = tolerance;
    options.initial_trust_region_radius = kFirstTrust;
    options.num_threads = 1;  // parallel sums would make the result depend on the schedule
    options.logging_type = ceres::SILENT;
    ShowIteration show(&progress);
    options.callbacks.push_back(&show);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary;
  }

  const CeilingNoise& noise_;
  const CeilingProblem& given_;
  CeilingUnknowns& unknowns_;
  ceres::LossFunctionWrapper sighting_loss_{nullptr, ceres::TAKE_OWNERSHIP};
  ceres::HuberLoss wheel_loss_{kWheelLoss};
  ceres::CauchyLoss level_loss_{1};
  ceres::Problem problem_{ProblemOptions()};
};

double MedianError_px(const CeilingProblem& problem, const CeilingUnknowns& unknowns) {
  std::vector<double> errors_px;
  for (const PointSighting& sighting : problem.sightings) {
    Eigen::Vector2d error;
    const bool is_seen =
        SightingError(problem, sighting.pixel, 1)(unknowns.keyframes[sighting.keyframe].data(),
                                                  unknowns.mounting.data(),
                                                  unknowns.points[sighting.point].data(),
                                                  error.data());
    if (is_seen) errors_px.push_back(error.norm());
  }
  return Median(std::move(errors_px));
}

}  // namespace

CeilingSolution SolveCeiling(const CeilingNoise& noise,
                             const CeilingProblem& problem,
                             Progress& progress,
                             CeilingUnknowns* unknowns) {
  Builder builder(noise, problem, unknowns);
  builder.AddSightings();
  builder.AddMotions();
  builder.AddMounting();
  builder.AddLevel();
  const ceres::Solver::Summary summary = builder.Solve(progress);
  if (!summary.IsSolutionUsable()) {
    throw DataError("the ceiling of {} keyframes and {} landmarks was not adjusted: {}",
                    unknowns->keyframes.size(),
                    unknowns->points.size(),
                    summary.message);
  }
  return {static_cast<int>(summary.iterations.size()) - 1,
          ceres::TerminationTypeToString(summary.termination_type),
          summary.initial_cost,
          summary.final_cost,
          MedianError_px(problem, *unknowns)};
}

}  // namespace nightmap
