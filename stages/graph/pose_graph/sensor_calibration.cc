// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/sensor_calibration.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/base/median.h"
#include "pipeline/geometry/levenberg_marquardt.h"
#include "pipeline/graph/sensor_stretches.h"

namespace nightmap {
namespace {

constexpr int kSize = CalibrationVector::RowsAtCompileTime;
constexpr std::size_t kMinStretches = 20;
constexpr int kNumRounds = 4;              // of residuals and their deviations
constexpr double kMinDeviation = 0.1;      // of a whitened residual: none is far better than stated
constexpr double kMinTurnRatio = 10;       // of squared turns and their noise
constexpr double kObservableShare = 0.25;  // of the prior's deviation

using Equations = NormalEquations<kSize>;
using Jacobian = Eigen::Matrix<double, 6, kSize>;

CalibrationVector PriorSigma() {
  CalibrationVector sigma;
  sigma << 0.5, 0.5, 0.5, 1, 1, 1, 0.05, 0.1;
  return sigma;
}

// Central differences take these steps.
CalibrationVector StepSize() {
  CalibrationVector step;
  step << 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 2e-3;
  return step;
}

Rigid3 Corrected(const Rigid3& pose, const CalibrationVector& value) {
  Vector6d turn = Vector6d::Zero();
  turn.head<3>() = value.head<3>();
  return {PerturbLeft(turn, {pose.rotation, Eigen::Vector3d::Zero()}).rotation,
          pose.translation + value.segment<3>(3)};
}

// Rotation vector, then translation.
Vector6d PerturbationOf(const Rigid3& pose) {
  const Eigen::AngleAxisd turn(pose.rotation);
  Vector6d vector;
  vector << turn.angle() * turn.axis(), pose.translation;
  return vector;
}

class Calibrator {
 public:
  Calibrator(const EdgeSigmaFloor& floor,
             const Mounting& mounting,
             std::vector<SensorStretch> stretches)
      : mounting_(mounting), stretches_(std::move(stretches)) {
    const int first = stretches_.front().run->camera_idx;
    const bool is_one = std::ranges::all_of(
        stretches_, [&](const SensorStretch& stretch) { return stretch.run->camera_idx == first; });
    if (is_one) result_.camera_idx = first;
    result_.given_pose = is_one ? CameraPose(first) : mounting_.robot_from_sensor;
    for (const SensorStretch& stretch : stretches_) whitening_.push_back(Whitening(floor, stretch));
  }

  SensorCalibration Run() {
    CalibrationVector weights = PriorSigma().cwiseAbs2().cwiseInverse();
    Solve(weights);
    if (!Turns()) SolveWithoutTurns(weights);
    result_.sigma = Sigma(weights);
    for (int i = 0; i < kSize; ++i) {
      const bool is_arm = i >= 3 && i < 6;
      const bool is_observable =
          result_.sigma[i] < kObservableShare * PriorSigma()[i] && (uses_turns_ || !is_arm);
      result_.is_observable.push_back(is_observable);
      if (!is_observable) weights[i] = 1e12;
    }
    Solve(weights);
    const CalibrationVector sigma = Sigma(weights);
    for (int i = 0; i < kSize; ++i) {
      const auto idx = static_cast<std::size_t>(i);
      if (result_.is_observable[idx]) result_.sigma[i] = sigma[i];
      if (!result_.is_observable[idx]) result_.value[i] = 0;
    }
    result_.num_stretches = static_cast<int>(stretches_.size());
    return result_;
  }

 private:
  const Rigid3& CameraPose(int camera_idx) const {
    return mounting_.robot_from_camera.at(static_cast<std::size_t>(camera_idx));
  }

  Rigid3 GivenSensorFromCamera(int camera_idx) const {
    return mounting_.robot_from_sensor.Inverse() * CameraPose(camera_idx);
  }

  Rigid3 SensorFromCamera(int camera_idx, const CalibrationVector& value) const {
    const Rigid3 pose = Corrected(result_.given_pose, value);
    return result_.camera_idx ? mounting_.robot_from_sensor.Inverse() * pose
                              : pose.Inverse() * CameraPose(camera_idx);
  }

  void SolveWithoutTurns(const CalibrationVector& weights) {
    uses_turns_ = false;
    result_.value.setZero();
    Solve(weights);
  }

  // Whether turns stand out from their noise, which else would tell of a lever arm and of axes.
  bool Turns() const {
    double turn2 = 0, noise2 = 0;
    for (const SensorStretch& stretch : stretches_) {
      const double by_sensor_rad = AngleBetween_rad(stretch.target_from_source, {});
      const double by_camera_rad = AngleBetween_rad(CameraMotion(stretch, result_.value), {});
      turn2 += by_sensor_rad * by_sensor_rad;
      noise2 += std::pow(by_sensor_rad - by_camera_rad, 2);
    }
    return turn2 > kMinTurnRatio * noise2;
  }

  Rigid3 CameraMotion(const SensorStretch& stretch, const CalibrationVector& value) const {
    const std::int64_t later_ns = std::llround(1e9 * value[kTimeIdx]);
    return stretch.run->At(stretch.target_ns + later_ns).Inverse() *
           stretch.run->At(stretch.source_ns + later_ns);
  }

  // Turns a residual to the sensor's axes, so that what moves and what does not stay apart, and
  // scales it by the stated covariance.
  Matrix6d Whitening(const EdgeSigmaFloor& floor, const SensorStretch& stretch) const {
    const Rigid3 sensor_from_camera = GivenSensorFromCamera(stretch.run->camera_idx);
    const Matrix6d turn = Adjoint({sensor_from_camera.rotation, Eigen::Vector3d::Zero()});
    const PoseEdge edge =
        WithSigmaFloor(floor, {0, 0, {}, turn * stretch.covariance * turn.transpose(), false});
    return edge.covariance.llt().matrixL().solve(turn);
  }

  // Motion by the sensor against that by the camera. The lever arm turns by the sensor's rotation:
  // the noise of the camera's would say that a plane robot tilts.
  Vector6d Residual(std::size_t i, const CalibrationVector& value) const {
    const SensorStretch& stretch = stretches_[i];
    const int camera_idx = stretch.run->camera_idx;
    const Rigid3 given = GivenSensorFromCamera(camera_idx);
    const Rigid3 corrected = SensorFromCamera(camera_idx, value);
    Rigid3 motion = given * stretch.target_from_source * given.Inverse();
    motion.translation /= 1 + value[kScaleIdx];
    const Rigid3 by_sensor = corrected.Inverse() * motion * corrected;
    Vector6d residual =
        whitening_[i] * PerturbationOf(by_sensor * CameraMotion(stretch, value).Inverse());
    if (!uses_turns_) residual.head<3>().setZero();
    return residual.cwiseQuotient(deviation_);
  }

  Jacobian JacobianOf(std::size_t i, const CalibrationVector& value) const {
    Jacobian jacobian;
    for (int k = 0; k < kSize; ++k) {
      const CalibrationVector step = StepSize()[k] * CalibrationVector::Unit(k);
      jacobian.col(k) =
          (Residual(i, value + step) - Residual(i, value - step)) / (2 * StepSize()[k]);
    }
    return jacobian;
  }

  Equations Build(const CalibrationVector& weights, const CalibrationVector& value) const {
    Equations equations;
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      const Vector6d residual = Residual(i, value);
      const Jacobian jacobian = JacobianOf(i, value);
      for (int row = 0; row < 6; ++row) {
        equations.AddRobust<1>(jacobian.row(row), residual.segment<1>(row));
      }
    }
    equations.AddPrior(weights, value);
    return equations;
  }

  void Solve(const CalibrationVector& weights) {
    const SmallSolverOptions options{.max_steps = 30, .min_gain = 1e-9};
    for (int round = 0; round < kNumRounds; ++round) {
      result_.value = MinimizeSmall<kSize>(
          options,
          result_.value,
          [&](const CalibrationVector& value) { return Build(weights, value); },
          [](const CalibrationVector& step, const CalibrationVector& value) {
            return CalibrationVector(value + step);
          });
      UpdateDeviation();
    }
  }

  void UpdateDeviation() {
    std::vector<double> sizes[6];
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      const Vector6d residual = Residual(i, result_.value).cwiseProduct(deviation_);
      for (int row = 0; row < 6; ++row) sizes[row].push_back(std::abs(residual[row]));
    }
    for (int row = 0; row < 6; ++row) {
      deviation_[row] = std::max(kMinDeviation, 1.4826 * Median(sizes[row]));
    }
  }

  CalibrationVector Sigma(const CalibrationVector& weights) const {
    const auto covariance = Build(weights, result_.value).Covariance();
    if (!covariance) return PriorSigma();
    return covariance->diagonal().cwiseSqrt();
  }

  const Mounting& mounting_;
  std::vector<SensorStretch> stretches_;
  std::vector<Matrix6d> whitening_;        // by stretch
  Vector6d deviation_ = Vector6d::Ones();  // of whitened residuals
  bool uses_turns_ = true;
  SensorCalibration result_;
};

}  // namespace

Rigid3 SensorCalibration::CorrectedPose() const { return Corrected(given_pose, value); }

std::optional<SensorCalibration> CalibrateSensor(const EdgeSigmaFloor& floor,
                                                 const std::vector<CameraRun>& camera_runs,
                                                 const SensorGraph& sensor) {
  if (!sensor.mounting) return std::nullopt;
  auto stretches = FindSensorStretches(camera_runs, sensor.odometry);
  if (stretches.size() < kMinStretches) return std::nullopt;
  return Calibrator(floor, *sensor.mounting, std::move(stretches)).Run();
}

}  // namespace nightmap
