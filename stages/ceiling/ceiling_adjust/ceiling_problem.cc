// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_adjust/ceiling_problem.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"

namespace nightmap {
namespace {

constexpr double kMinDepth_m = 0.05;
// Where a motion is so short that its own noise is none, samples and rounding remain.
constexpr double kMinMotionSigma_m = 5e-4;
constexpr double kMinMotionSigma_rad = 1e-3;
constexpr double kMountingSigma_m = 0.03;
constexpr double kSightingLoss = 1.5;  // in standard deviations, as the next
// A loop moves a long way: sightings that are so far off pull like others until it has moved.
constexpr double kFirstSightingLoss = 100;
constexpr double kWheelLoss = 3;
constexpr double kLevelSigma_m = 0.01;  // of a ceiling that is level
// Decrease of the cost, as a share of it, from which it is at its minimum: what is left then is of
// corners whose place no picture tells.
constexpr double kFirstTolerance = 1e-2, kTolerance = 1e-5;
// Damping of a keyframe's own curvature over less than this holds the long waves of a long way,
// which are all but flat, where they are.
constexpr double kFirstTrust = 1e10;
constexpr int kMaxIterations = 50;

class SightingError {
 public:
  SightingError(const CeilingProblem& problem, const Eigen::Vector2d& pixel, double sigma_px)
      : camera_(problem.camera),
        camera_from_robot_(problem.robot_from_camera.rotation.conjugate().toRotationMatrix()),
        mounted_at_(problem.robot_from_camera.translation),
        pixel_(pixel),
        sigma_px_(sigma_px) {}

  template <typename T>
  bool operator()(const T* keyframe, const T* mounting, const T* point, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const T cosine = ceres::cos(keyframe[2]), sine = ceres::sin(keyframe[2]);
    const T x = point[0] - keyframe[0], y = point[1] - keyframe[1];
    const Vector from_camera(cosine * x + sine * y - mounted_at_.x() - mounting[3],
                             cosine * y - sine * x - mounted_at_.y() - mounting[4],
                             point[2] - mounted_at_.z());
    const Vector as_mounted = camera_from_robot_.cast<T>() * from_camera;
    const T tilt[3] = {-keyframe[3] - mounting[0], -keyframe[4] - mounting[1], -mounting[2]};
    T in_camera[3];
    ceres::AngleAxisRotatePoint(tilt, as_mounted.data(), in_camera);
    if (in_camera[2] < kMinDepth_m) return false;
    residual[0] = (camera_.fx * in_camera[0] / in_camera[2] + camera_.cx - pixel_.x()) / sigma_px_;
    residual[1] = (camera_.fy * in_camera[1] / in_camera[2] + camera_.cy - pixel_.y()) / sigma_px_;
    return true;
  }

 private:
  Camera camera_;
  Eigen::Matrix3d camera_from_robot_;
  Eigen::Vector3d mounted_at_;
  Eigen::Vector2d pixel_;
  double sigma_px_;
};

// Along and across the robot's heading, and of it.
Eigen::Vector3d SigmaOf(const CeilingNoise& noise, const KeyframeMotion& motion) {
  if (!motion.is_measured) {
    const double unknown_m = noise.unknown_speed_m_per_s * motion.time_s;
    return {unknown_m, unknown_m, noise.unknown_turn_rad_per_s * motion.time_s};
  }
  const double along_m = noise.distance_sigma_m * std::sqrt(motion.distance_m);
  const double turn_rad = std::hypot(noise.heading_sigma_rad * std::sqrt(motion.distance_m),
                                     noise.turn_sigma_rad * std::sqrt(motion.turn_rad));
  return {std::hypot(along_m, kMinMotionSigma_m),
          std::hypot(0.2 * along_m, kMinMotionSigma_m),
          std::hypot(turn_rad, kMinMotionSigma_rad)};
}

class MotionError {
 public:
  MotionError(const CeilingNoise& noise, const KeyframeMotion& motion)
      : motion_(motion), sigma_(SigmaOf(noise, motion)) {}

  template <typename T>
  bool operator()(const T* before, const T* after, const T* wheels, T* residual) const {
    const T turned_rad = wheels[1] * motion_.distance_m;
    const T heading_rad = before[2] + 0.5 * turned_rad;
    const T cosine = ceres::cos(heading_rad), sine = ceres::sin(heading_rad);
    const T x = after[0] - before[0], y = after[1] - before[1];
    const Rigid2& measured = motion_.before_from_after;
    // The motion that the wheels should have measured, so that a smaller map does not make their
    // noise smaller.
    const T scale = 1.0 / (1.0 + wheels[0]);
    residual[0] = scale * (cosine * x + sine * y) - measured.translation.x();
    residual[1] = scale * (cosine * y - sine * x) - measured.translation.y();
    residual[2] = after[2] - before[2] - measured.heading_rad - turned_rad;
    const T turns = ceres::floor(residual[2] / (2 * std::numbers::pi) + 0.5);
    residual[2] -= turns * (2 * std::numbers::pi);
    for (int i = 0; i < 3; ++i) residual[i] /= sigma_[i];
    return true;
  }

 private:
  KeyframeMotion motion_;
  Eigen::Vector3d sigma_;
};

// Values that are near those expected: residual = (value - expected) / sigma.
template <int kSize, int kFirst, int kNum>
class ExpectedValues {
 public:
  using Values = Eigen::Matrix<double, kNum, 1>;
  ExpectedValues(const Values& expected, const Values& sigma)
      : expected_(expected), sigma_(sigma) {}

  static ceres::CostFunction* Cost(const Values& expected, const Values& sigma) {
    return new ceres::AutoDiffCostFunction<ExpectedValues, kNum, kSize>(
        new ExpectedValues(expected, sigma.cwiseMax(1e-9)));
  }

  template <typename T>
  bool operator()(const T* values, T* residual) const {
    for (int i = 0; i < kNum; ++i) residual[i] = (values[kFirst + i] - expected_[i]) / sigma_[i];
    return true;
  }

 private:
  Values expected_, sigma_;
};

class LevelError {
 public:
  template <typename T>
  bool operator()(const T* point, const T* level, T* residual) const {
    residual[0] = (point[2] - level[0]) / kLevelSigma_m;
    return true;
  }
};

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
