// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/ceiling_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/ceiling/planar_pose.h"
#include "stages/ceiling/ceiling_ekf/sparse_rows.h"

namespace nightmap {
namespace {

CompressedEkf StartOf(const CeilingNoise& noise) {
  Eigen::VectorXd variance = Eigen::VectorXd::Constant(kNumFixed, kExactVariance);
  variance.segment<2>(kVibration).setConstant(std::pow(noise.vibration_sigma_rad, 2));
  variance[kScale] = std::pow(noise.scale_sigma, 2);
  variance[kHeadingError] = std::pow(noise.heading_bias_sigma_rad_per_m, 2);
  variance.segment<2>(kMounting).setConstant(std::pow(noise.mounting_tilt_sigma_rad, 2));
  variance = variance.cwiseMax(kExactVariance);
  return {Eigen::VectorXd::Zero(kNumFixed), variance.asDiagonal(), kScale};
}

}  // namespace

CeilingFilter::CeilingFilter(const UpwardCamera& camera, const CeilingNoise& noise)
    : camera_(camera), noise_(noise), filter_(StartOf(noise)) {}

void CeilingFilter::Predict(const ControlInput& input) {
  const Eigen::Index n = filter_.NumActive();
  Eigen::VectorXd mean = filter_.Active();
  const double heading_rad = mean[kRobot + 2] + 0.5 * mean[kHeadingError] * input.distance_m;
  const Eigen::Vector2d measured =
      Eigen::Rotation2Dd(heading_rad) * input.before_from_after.translation;
  const Eigen::Vector2d moved = (1 + mean[kScale]) * measured;
  mean.segment<2>(kRobot) += moved;
  mean[kRobot + 2] += input.before_from_after.heading_rad + mean[kHeadingError] * input.distance_m;
  mean.segment<2>(kVibration).setZero();

  SparseRowsBuilder jacobian(n, n);
  jacobian.Identity(0, kVibration);
  jacobian.Identity(kScale, n - kScale);
  // The way leads from prediction to prediction, so that what the last update changed is in it.
  const Eigen::Vector2d way = (mean.segment<3>(kRobot) - robot_linearized_at_).head<2>();
  robot_linearized_at_ = mean.segment<3>(kRobot);
  const Eigen::Vector2d across(-way.y(), way.x());
  jacobian.Add(kRobot, kRobot + 2, across);
  jacobian.Add(kRobot, kScale, way);
  jacobian.Add(kRobot, kHeadingError, 0.5 * input.distance_m * across);
  jacobian.Add(kRobot + 2, kHeadingError, Eigen::Matrix<double, 1, 1>(input.distance_m));

  const double distance_m = input.distance_m;
  Eigen::Vector3d sigma(noise_.distance_sigma_m * std::sqrt(distance_m),
                        0.2 * noise_.distance_sigma_m * std::sqrt(distance_m),
                        std::hypot(noise_.heading_sigma_rad * std::sqrt(distance_m),
                                   noise_.turn_sigma_rad * std::sqrt(input.turn_rad)));
  if (input.unknown_time_s > 0) {
    // A difference of speed that stays adds up to the square of the whole time.
    const double until_s = unknown_since_s_ + input.unknown_time_s;
    const double share_s = std::sqrt(until_s * until_s - unknown_since_s_ * unknown_since_s_);
    const double unknown_m = noise_.unknown_speed_m_per_s * share_s;
    sigma += Eigen::Vector3d(unknown_m, unknown_m, noise_.unknown_turn_rad_per_s * share_s);
    unknown_since_s_ = until_s;
  } else {
    unknown_since_s_ = 0;
  }
  SparseRowsBuilder noise(n, n);
  noise.Add(kRobot, kRobot, TurnedVariance(mean[kRobot + 2], sigma));
  const double vibration = std::max(std::pow(noise_.vibration_sigma_rad, 2), kExactVariance);
  noise.Add(kVibration, kVibration, vibration * Eigen::Matrix2d::Identity());
  filter_.Transform(std::move(mean), jacobian.Build(), noise.Build());
}

void CeilingFilter::Loosen(const Eigen::Vector3d& sigma) {
  const Eigen::Index n = filter_.NumActive();
  SparseRowsBuilder jacobian(n, n), noise(n, n);
  jacobian.Identity(0, n);
  noise.Add(kRobot, kRobot, TurnedVariance(filter_.Active()[kRobot + 2], sigma));
  filter_.Transform(filter_.Active(), jacobian.Build(), noise.Build());
}

const CeilingFilter::Part* CeilingFilter::FindLandmark(std::int64_t track_id) const {
  const auto found = std::ranges::lower_bound(landmarks_, track_id, {}, &Part::id);
  return found != landmarks_.end() && found->id == track_id ? &*found : nullptr;
}

const CeilingFilter::Part& CeilingFilter::FindClone(std::int64_t clone_id) const {
  return *std::ranges::find(clones_, clone_id, &Part::id);
}

std::optional<UpwardCamera::Projection> CeilingFilter::Expect(const Part& landmark) const {
  const Eigen::VectorXd& state = filter_.Active();
  return camera_.Project(state.segment<3>(kRobot),
                         state.segment<2>(kVibration) + state.segment<2>(kMounting),
                         state.segment<3>(landmark.first));
}

Measurement CeilingFilter::Measure(const std::vector<LandmarkSighting>& sightings,
                                   std::vector<std::size_t>* measured) const {
  const auto num = static_cast<Eigen::Index>(2 * sightings.size());
  SparseRowsBuilder rows(num, filter_.NumActive());
  Measurement measurement;
  measurement.residual.setZero(num);
  measurement.variance.setConstant(num, std::pow(noise_.pixel_sigma_px, 2));
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const LandmarkSighting& sighting = sightings[i];
    const Part* landmark = FindLandmark(sighting.track_id);
    const auto expected = landmark ? Expect(*landmark) : std::nullopt;
    if (!expected) continue;
    const auto linear = camera_.Project(
        robot_linearized_at_,
        filter_.Active().segment<2>(kVibration) + filter_.Active().segment<2>(kMounting),
        landmark->linearized_at);
    if (!linear) continue;
    rows.Add(row, kRobot, linear->by_pose);
    rows.Add(row, kVibration, linear->by_tilt);
    rows.Add(row, kMounting, linear->by_tilt);
    rows.Add(row, landmark->first, linear->by_point);
    measurement.residual.segment<2>(row) = sighting.pixel - expected->pixel;
    row += 2;
    if (measured) measured->push_back(i);
  }
  measurement.active = rows.Build().topRows(row);
  measurement.residual.conservativeResize(row);
  measurement.variance.conservativeResize(row);
  return measurement;
}

std::vector<double> CeilingFilter::Gates(const std::vector<LandmarkSighting>& sightings) const {
  std::vector<double> gates(sightings.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> measured;
  const Measurement measurement = Measure(sightings, &measured);
  const std::vector<double> squared = filter_.Test(measurement, 2);
  for (std::size_t i = 0; i < measured.size(); ++i) gates[measured[i]] = squared[i];
  return gates;
}

Innovation CeilingFilter::Observe(const std::vector<LandmarkSighting>& sightings) {
  const Measurement measurement = Measure(sightings);
  return measurement.residual.size() == 0 ? Innovation{} : filter_.Update(measurement);
}

std::vector<LandmarkSighting> CeilingFilter::Agreeing(
    const std::vector<LandmarkSighting>& sightings, double max_sigmas) const {
  const double limit_px = max_sigmas * noise_.pixel_sigma_px;
  std::vector<LandmarkSighting> agreeing;
  for (const LandmarkSighting& sighting : sightings) {
    const Part* landmark = FindLandmark(sighting.track_id);
    const auto expected = landmark ? Expect(*landmark) : std::nullopt;
    if (!expected) continue;
    const Eigen::Vector2d off_px = sighting.pixel - expected->pixel;
    if (off_px.cwiseAbs().maxCoeff() <= limit_px) agreeing.push_back(sighting);
  }
  return agreeing;
}

double CeilingFilter::Surprise(const CeilingFilter& after) const {
  const Eigen::Vector3d change =
      after.filter_.Active().segment<3>(kRobot) - filter_.Active().segment<3>(kRobot);
  const Eigen::Matrix3d expected = filter_.ActiveCovariance().block<3, 3>(kRobot, kRobot);
  return change.dot(expected.llt().solve(change));
}

double CeilingFilter::WheelSigma_m(double distance_m) const {
  return noise_.distance_sigma_m * std::sqrt(distance_m) + noise_.scale_sigma * distance_m;
}

Rigid2 CeilingFilter::AnchorFromRobot() const {
  return ToRigid2(Eigen::Vector3d(filter_.Active().segment<3>(kRobot)));
}

Rigid2 CeilingFilter::MapFromRobot() const {
  return ToRigid2(Eigen::Vector3d(filter_.Active().segment<3>(kAnchor))) * AnchorFromRobot();
}

Eigen::Matrix3d CeilingFilter::RobotCovariance() const {
  const ComposedPose composed =
      Compose(filter_.Active().segment<3>(kAnchor), filter_.Active().segment<3>(kRobot));
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << composed.by_first, composed.by_second;
  const Eigen::Matrix3d covariance =
      jacobian * filter_.ActiveCovariance().topLeftCorner<6, 6>() * jacobian.transpose();
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace nightmap
