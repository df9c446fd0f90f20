// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/geometry/check_bundle.h"
#include "pipeline/geometry/schur_system.h"

namespace nightmap {
namespace {

PointMotion MotionOf(std::size_t pose, const BundleProblem& data) {
  return data.motions.empty() ? PointMotion{} : data.motions[pose];
}

PointMeasurement Measured(const BundleObservation& o) {
  const bool has_depth = o.depth_m > 0;
  return {
      o.pixel, o.depth_m, 1 / o.pixel_sigma_px, has_depth ? 1 / o.noise.Sigma_m(o.depth_m) : 0.0};
}

Reprojection Reproject(const BundleProblem& data, const BundleObservation& observation) {
  const auto pose = static_cast<std::size_t>(observation.pose_idx);
  const auto point = static_cast<std::size_t>(observation.point_idx);
  const Camera& camera = data.cameras[pose];
  return {camera,
          data.camera_from_world[pose] * data.points_in_world[point],
          RowFraction(camera, observation.pixel),
          MotionOf(pose, data),
          data.calibrations[data.SensorOf(observation)]};
}

// Nothing for a point that the camera cannot see.
std::optional<Eigen::Vector3d> Residual(const BundleProblem& data,
                                        const BundleObservation& observation) {
  const Reprojection seen = Reproject(data, observation);
  if (!seen.IsVisible()) return {};
  return seen.Residual(Measured(observation));
}

// Requires a point that the camera can see.
LinearObservation Linearized(const BundleProblem& data,
                             const BundleObservation& observation,
                             DepthCalibration moved) {
  const Reprojection seen = Reproject(data, observation);
  const PointMeasurement measured = Measured(observation);
  const Eigen::Matrix3d by_p = seen.ByMovedPoint(measured);
  const Eigen::Matrix3d by_middle = seen.ByMiddlePoint(by_p);
  const Rigid3& camera_from_world =
      data.camera_from_world[static_cast<std::size_t>(observation.pose_idx)];
  return {{seen.ByPose(by_middle),
           by_middle * camera_from_world.rotation.toRotationMatrix(),
           seen.ByCalibration(measured, by_p, moved)},
          seen.Residual(measured)};
}

// A wrong match may put a point behind a camera that observes it; no step could start from there.
void DropUnseeable(BundleProblem* data) {
  std::erase_if(data->observations,
                [&](const BundleObservation& o) { return !Residual(*data, o); });
}

// Levenberg-Marquardt on residuals weighted by the robust loss at each estimate. The trust region
// grows and shrinks as in Nielsen, 1999 (Damping Parameter in Marquardt's Method, IMM-REP-1999-05).
class Adjuster {
 public:
  Adjuster(const BundleOptions& options, BundleProblem* data)
      : options_(options),
        data_(*data),
        has_calibrations_(options.calibrate || options.depth != DepthCalibration::kHeld),
        system_(
            *data,
            has_calibrations_,
            options.num_threads,
            [this](std::size_t observation) { return Linear(data_.observations[observation]); }),
        costs_(data->observations.size()) {}

  BundleSummary Run() {
    BundleSummary summary;
    summary.initial_cost = summary.final_cost = Cost();
    summary.end = BundleEnd::kMaxIterations;
    double promised = 0;  // largest decrease that any of the successive refused steps predicted
    int num_refused = 0;
    while (summary.num_iterations < options_.max_iterations && num_refused <= kMaxRefused) {
      ++summary.num_iterations;
      const Trial trial = TryStep(summary.final_cost);
      if (!trial.is_accepted) {
        trust_ /= distrust_;
        distrust_ *= 2;
        ++num_refused;
        promised = std::max(promised, trial.predicted);
        continue;
      }
      ++summary.num_accepted;
      summary.final_cost -= trial.decrease;
      if (trial.decrease <= kMinRelativeDecrease * summary.final_cost) {
        summary.end = BundleEnd::kConverged;
        break;
      }
      num_refused = 0;
      promised = 0;
      const double of_predicted = trial.decrease / trial.predicted;
      trust_ /= std::max(1.0 / 3, 1 - std::pow(2 * of_predicted - 1, 3));
      trust_ = std::min(trust_, kMaxTrust);
      distrust_ = 2;
    }
    if (num_refused > 0) summary.end = EndAfterRefusals(promised, summary);
    return summary;
  }

  // At the current estimate.
  double DepthSigma(std::size_t sensor) {
    return system_.CalibrationSigma(Priors(), static_cast<Eigen::Index>(3 * sensor + 2));
  }

 private:
  static constexpr int kMaxRefused = 30;  // in a row; each step is shorter than the previous one
  // A smaller relative decrease of the cost ends the adjustment.
  static constexpr double kMinRelativeDecrease = 1e-5;
  static constexpr double kNoDecrease = 1e-9;      // rounding error when everything fits exactly
  static constexpr double kMinOfPredicted = 1e-3;  // a smaller share refuses the step
  static constexpr double kMaxTrust = 1e12;

  struct Trial {
    bool is_accepted = false;  // otherwise nothing changed
    double decrease = 0;
    double predicted = std::numeric_limits<double>::infinity();  // when there is no step
  };

  // End of an adjustment whose last steps were refused, or gained little after refused ones:
  // converged if nothing was left to gain, stalled otherwise.
  static BundleEnd EndAfterRefusals(double promised, const BundleSummary& summary) {
    if (promised <= kMinRelativeDecrease * summary.final_cost + kNoDecrease) {
      return BundleEnd::kConverged;
    }
    if (summary.num_accepted > 0) return BundleEnd::kStalled;
    throw DataError(
        "bundle adjustment: none of {} steps lowered the cost of {:.6g}, though one should have by "
        "{:.6g}; {}",
        summary.num_iterations,
        summary.initial_cost,
        promised,
        kBundleRemedy);
  }

  // Refuses a step that does not lower the cost as it should.
  Trial TryStep(double cost) {
    const auto step = system_.Solve(Priors(), trust_);
    if (!step) return {};
    const auto poses = data_.camera_from_world;
    const auto points = data_.points_in_world;
    const auto calibrations = data_.calibrations;
    Move(*step);
    Trial trial;
    trial.decrease = cost - Cost();
    if (std::isfinite(step->predicted_decrease)) trial.predicted = step->predicted_decrease;
    trial.is_accepted = trial.decrease / step->predicted_decrease > kMinOfPredicted;
    if (trial.is_accepted) {
      system_.EstimateMoved();
      return trial;
    }
    data_.camera_from_world = poses;
    data_.points_in_world = points;
    data_.calibrations = calibrations;
    return trial;
  }

  void Move(const BundleStep& step) {
    for (std::size_t i = 0; i < step.poses.size(); ++i) {
      if (data_.is_fixed[i]) continue;
      data_.camera_from_world[i] = PerturbLeft(step.poses[i], data_.camera_from_world[i]);
    }
    for (std::size_t k = 0; k < step.points.size(); ++k) {
      data_.points_in_world[k] += step.points[k];
    }
    for (std::size_t i = 0; i < step.calibrations.size(); ++i) {
      data_.calibrations[i].focal_scale += step.calibrations[i][0];
      data_.calibrations[i].readout_s += step.calibrations[i][1];
      DepthParameter(data_.calibrations[i]) += step.calibrations[i][2];
    }
  }

  // Half the robust sum; infinite where a camera can no longer see a point that it observes.
  double Cost() {
    ParallelFor(costs_.size(), options_.num_threads, [&](std::size_t i) {
      const auto residual = Residual(data_, data_.observations[i]);
      costs_[i] =
          residual ? Loss(residual->squaredNorm()) : std::numeric_limits<double>::infinity();
    });
    double sum = 0;
    for (const double cost : costs_) sum += cost;
    for (std::size_t i = 0; has_calibrations_ && i < data_.calibrations.size(); ++i) {
      const Eigen::Vector3d deviation = Deviation(i);
      sum += deviation.dot(Weights(i).cwiseProduct(deviation));
    }
    return 0.5 * sum;
  }

  LinearObservation Linear(const BundleObservation& observation) const {
    LinearObservation linear = Linearized(data_, observation, options_.depth);
    auto& [jacobian, residual] = linear;
    const double weight = std::sqrt(LossDerivative(residual.squaredNorm()));
    residual *= weight;
    jacobian.by_pose *= weight;
    jacobian.by_point *= weight;
    jacobian.by_calibration *= weight * Free(data_.SensorOf(observation)).asDiagonal();
    return linear;
  }

  double Loss(double squared) const {
    const double scale2 = options_.robust_scale * options_.robust_scale;
    if (options_.loss == RobustLoss::kCauchy) return scale2 * std::log1p(squared / scale2);
    return squared <= scale2 ? squared : 2 * options_.robust_scale * std::sqrt(squared) - scale2;
  }
  double LossDerivative(double squared) const {
    const double scale2 = options_.robust_scale * options_.robust_scale;
    if (options_.loss == RobustLoss::kCauchy) return 1 / (1 + squared / scale2);
    return squared <= scale2 ? 1 : options_.robust_scale / std::sqrt(squared);
  }

  double& DepthParameter(CameraCalibration& calibration) const {
    return options_.depth == DepthCalibration::kOffset ? calibration.depth_offset_m
                                                       : calibration.depth_scale;
  }

  // 1 for each of focal scale, readout and the depth's parameter that may change.
  Eigen::Vector3d Free(std::size_t sensor) const {
    const double calibrates = options_.calibrate ? 1 : 0;
    const bool is_depth_free = options_.depth == DepthCalibration::kOffset ||
                               (options_.depth == DepthCalibration::kScale && sensor > 0);
    return {calibrates, calibrates, is_depth_free ? 1.0 : 0.0};
  }

  // Deviation of a calibration from its prior, and the prior's weight. Depth has no prior.
  Eigen::Vector3d Deviation(std::size_t sensor) const {
    const CameraCalibration& now = data_.calibrations[sensor];
    return Free(sensor).cwiseProduct(Eigen::Vector3d(now.focal_scale - 1, now.readout_s, 0));
  }
  Eigen::Vector3d Weights(std::size_t sensor) const {
    const Eigen::Vector3d weights(
        std::pow(options_.focal_scale_sigma, -2), std::pow(options_.readout_sigma_s, -2), 0);
    return Free(sensor).cwiseProduct(weights);
  }

  // A parameter that is held has no derivative, so any weight leaves it in place.
  std::vector<LinearPrior> Priors() const {
    std::vector<LinearPrior> priors;
    for (std::size_t i = 0; i < data_.calibrations.size(); ++i) {
      const Eigen::Vector3d held = Eigen::Vector3d::Ones() - Free(i);
      priors.push_back({Weights(i) + held, Weights(i).cwiseProduct(Deviation(i))});
    }
    return priors;
  }

  const BundleOptions& options_;
  BundleProblem& data_;
  bool has_calibrations_;
  SchurSystem system_;
  std::vector<double> costs_;  // by observation
  double trust_ = 1e4;
  double distrust_ = 2;
};

}  // namespace

const char* BundleEndText(BundleEnd end) {
  switch (end) {
    case BundleEnd::kNothingSeen:
      return "nothing seen";
    case BundleEnd::kConverged:
      return "converged";
    case BundleEnd::kMaxIterations:
      return "max_iterations reached";
    case BundleEnd::kStalled:
      return "stalled";
  }
  return "";
}

BundleSummary AdjustBundle(const BundleOptions& options, BundleProblem* data) {
  CheckBundle(*data);
  DropUnseeable(data);
  if (data->observations.empty()) return {};
  return Adjuster(options, data).Run();
}

DepthOffsets EstimateDepthOffsets(BundleOptions options, BundleProblem adjusted) {
  constexpr int kSteps = 5;
  options.depth = DepthCalibration::kOffset;
  options.max_iterations = kSteps;
  CheckBundle(adjusted);
  DropUnseeable(&adjusted);
  if (adjusted.observations.empty()) return {};
  try {
    Adjuster adjuster(options, &adjusted);
    (void)adjuster.Run();
    DepthOffsets found;
    for (std::size_t sensor = 0; sensor < adjusted.calibrations.size(); ++sensor) {
      found.offset_m.push_back(adjusted.calibrations[sensor].depth_offset_m);
      found.sigma_m.push_back(adjuster.DepthSigma(sensor));
    }
    return found;
  } catch (const DataError&) {
    return {};  // no step led nearer, or no room for the factor: the map does not need the offsets
  }
}

double ReprojectionError_px(const BundleProblem& data, const BundleObservation& observation) {
  const auto residual = Residual(data, observation);
  return residual ? observation.pixel_sigma_px * residual->head<2>().norm()
                  : std::numeric_limits<double>::infinity();
}

}  // namespace nightmap
