// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling_ekf/ceiling_filter.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "stages/ceiling_ekf/planar_pose.h"
#include "stages/ceiling_ekf/sparse_rows.h"

namespace nightmap {
namespace {

// Where the parts of the active state begin.
constexpr Eigen::Index kAnchor = 0;
constexpr Eigen::Index kRobot = 3;
constexpr Eigen::Index kVibration = 6;
constexpr Eigen::Index kScale = 8;
constexpr Eigen::Index kHeadingError = 9;
constexpr Eigen::Index kMounting = 10;
constexpr Eigen::Index kNumFixed = 12;
constexpr Eigen::Index kCloneSize = 5;
constexpr Eigen::Index kLandmarkSize = 3;
// Of what is exact by definition, so that the covariance stays positive definite: 10 um, 10 urad.
constexpr double kExactVariance = 1e-10;
// Of a depth that is not known yet, relative to it.
constexpr double kDepthSigma = 10;

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

void CeilingNoise::Register(OptionList& list) {
  list.Add("pixel_sigma_px", &pixel_sigma_px, Range(0.01, 10), "noise of a corner in a picture");
  list.Add("distance_sigma_m",
           &distance_sigma_m,
           Range(1e-4, 1),
           "noise of the wheels' distance after 1 m; grows with the distance's root");
  list.Add("heading_sigma_rad",
           &heading_sigma_rad,
           Range(1e-5, 1),
           "noise of the wheels' heading after 1 m; grows with the distance's root");
  list.Add("turn_sigma_rad",
           &turn_sigma_rad,
           Range(1e-5, 1),
           "noise of the wheels' heading after a turn of 1 rad; grows with the turn's root");
  list.Add("scale_sigma",
           &scale_sigma,
           Range(0, 0.5),
           "share by which all distances of the wheels may be wrong; no picture tells it, so the "
           "map's size is as wrong as the wheels are");
  list.Add("heading_bias_sigma_rad_per_m",
           &heading_bias_sigma_rad_per_m,
           Range(0, 1),
           "turn that the wheels may make up per metre all the time");
  list.Add("mounting_tilt_sigma_rad",
           &mounting_tilt_sigma_rad,
           Range(0, 0.3),
           "tilt of the camera against robot_from_camera, about each of its axes");
  list.Add("vibration_sigma_rad",
           &vibration_sigma_rad,
           Range(0, 0.1),
           "tilt of the driving robot, from frame to frame");
  list.Add("unknown_speed_m_per_s",
           &unknown_speed_m_per_s,
           Range(0, 10),
           "speed of a robot whose wheels say nothing");
  list.Add("unknown_turn_rad_per_s",
           &unknown_turn_rad_per_s,
           Range(0, 10),
           "turning speed of a robot whose wheels say nothing");
}

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
  // From prediction to prediction, what the last update changed included.
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
    // Of a difference of speed that stays: its variances add up to the square of the whole time.
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

std::int64_t CeilingFilter::AddClone() {
  const Eigen::Index n = filter_.NumActive();
  Eigen::VectorXd mean(n + kCloneSize);
  mean << filter_.Active(), filter_.Active().segment<kCloneSize>(kRobot);
  SparseRowsBuilder jacobian(n + kCloneSize, n), noise(n + kCloneSize, n + kCloneSize);
  jacobian.Identity(0, n);
  jacobian.Add(n, kRobot, Eigen::Matrix<double, kCloneSize, kCloneSize>::Identity());
  noise.Add(n, n, kExactVariance * Eigen::Matrix<double, kCloneSize, kCloneSize>::Identity());
  filter_.Transform(std::move(mean), jacobian.Build(), noise.Build());
  clones_.push_back({next_clone_id_, n, robot_linearized_at_});
  return next_clone_id_++;
}

bool CeilingFilter::AddLandmark(std::int64_t track_id,
                                std::int64_t clone_id,
                                const Eigen::Vector2d& from,
                                const Eigen::Vector2d& now,
                                double min_parallax_rad,
                                double gate) {
  const Eigen::VectorXd& state = filter_.Active();
  const Eigen::Index n = filter_.NumActive();
  const Part& then = FindClone(clone_id);
  const Eigen::Index clone = then.first;
  const Eigen::Vector2d mounting = state.segment<2>(kMounting);
  const UpwardCamera::View then_view{
      state.segment<3>(clone), state.segment<2>(clone + 3) + mounting, from};
  const UpwardCamera::View now_view{
      state.segment<3>(kRobot), state.segment<2>(kVibration) + mounting, now};
  const auto depth_m = camera_.Triangulate(now_view, then_view, min_parallax_rad);
  if (!depth_m) return false;

  const UpwardCamera::RayPoint ray =
      camera_.PointAt(then_view.pose, then_view.tilt_rad, from, *depth_m);
  Eigen::VectorXd mean(n + kLandmarkSize);
  mean << state, ray.point;
  SparseRowsBuilder jacobian(n + kLandmarkSize, n), noise(n + kLandmarkSize, n + kLandmarkSize);
  jacobian.Identity(0, n);
  jacobian.Add(n, clone, ray.by_pose);
  jacobian.Add(n, clone + 3, ray.by_tilt);
  jacobian.Add(n, kMounting, ray.by_tilt);
  const Matrix32d by_pixel = ray.by_pixel * noise_.pixel_sigma_px;
  const Eigen::Vector3d by_depth = ray.by_depth * (kDepthSigma * *depth_m);
  noise.Add(n, n, by_pixel * by_pixel.transpose() + by_depth * by_depth.transpose());
  filter_.Transform(std::move(mean), jacobian.Build(), noise.Build());
  const auto place = std::ranges::lower_bound(landmarks_, track_id, {}, &Part::id);
  const Eigen::Vector3d linearized_at =
      camera_.PointAt(then.linearized_at, then_view.tilt_rad, from, *depth_m).point;
  landmarks_.insert(place, {track_id, n, linearized_at});
  if (Gates({{track_id, now}})[0] > gate) {
    RemoveLandmarks({track_id});
    return false;
  }
  Observe({{track_id, now}});
  return true;
}

void CeilingFilter::Remove(const std::vector<std::int64_t>& ids,
                           Eigen::Index size,
                           std::vector<Part>* parts) {
  if (ids.empty()) return;
  std::vector<char> goes(static_cast<std::size_t>(filter_.NumActive()));
  std::erase_if(*parts, [&](const Part& part) {
    if (!std::ranges::count(ids, part.id)) return false;
    std::fill_n(goes.begin() + part.first, size, 1);
    return true;
  });
  std::vector<Eigen::Index> rest, now_at(goes.size());
  for (std::size_t i = 0; i < goes.size(); ++i) {
    now_at[i] = static_cast<Eigen::Index>(rest.size());
    if (!goes[i]) rest.push_back(static_cast<Eigen::Index>(i));
  }
  filter_.Select(rest);
  for (auto* list : {&clones_, &landmarks_}) {
    for (Part& part : *list) part.first = now_at[static_cast<std::size_t>(part.first)];
  }
}

void CeilingFilter::RemoveClones(const std::vector<std::int64_t>& clone_ids) {
  Remove(clone_ids, kCloneSize, &clones_);
}

void CeilingFilter::RemoveLandmarks(const std::vector<std::int64_t>& track_ids) {
  Remove(track_ids, kLandmarkSize, &landmarks_);
}

std::vector<ActiveLandmark> CeilingFilter::Landmarks() const {
  std::vector<ActiveLandmark> landmarks;
  for (const Part& part : landmarks_) {
    landmarks.push_back({part.id,
                         filter_.Active().segment<3>(part.first),
                         filter_.ActiveCovariance().block<3, 3>(part.first, part.first)});
  }
  return landmarks;
}

void CeilingFilter::MoveAnchor() {
  const Eigen::Index n = filter_.NumActive();
  const Eigen::VectorXd& state = filter_.Active();
  const Eigen::Vector3d robot = state.segment<3>(kRobot);
  Eigen::VectorXd mean(n + 3);
  mean << state, state.segment<3>(kAnchor);
  SparseRowsBuilder jacobian(n + 3, n), noise(n + 3, n + 3);
  // The old anchor goes to the end, to be kept.
  jacobian.Identity(n, 3, kAnchor);
  mean.segment<3>(kAnchor) = Compose(state.segment<3>(kAnchor), robot).pose;
  const ComposedPose moved = Compose(state.segment<3>(kAnchor), robot_linearized_at_);
  jacobian.Add(kAnchor, kAnchor, moved.by_first);
  jacobian.Add(kAnchor, kRobot, moved.by_second);
  mean.segment<3>(kRobot).setZero();
  noise.Add(kRobot, kRobot, kExactVariance * Eigen::Matrix3d::Identity());
  jacobian.Identity(kVibration, kNumFixed - kVibration);
  for (Part& clone : clones_) {
    mean.segment<3>(clone.first) = Between(robot, state.segment<3>(clone.first)).pose;
    const ComposedPose seen = Between(robot_linearized_at_, clone.linearized_at);
    clone.linearized_at = seen.pose;
    jacobian.Add(clone.first, kRobot, seen.by_first);
    jacobian.Add(clone.first, clone.first, seen.by_second);
    jacobian.Identity(clone.first + 3, 2);
  }
  for (Part& landmark : landmarks_) {
    mean.segment<3>(landmark.first) = PointFrom(robot, state.segment<3>(landmark.first)).point;
    const SeenPoint seen = PointFrom(robot_linearized_at_, landmark.linearized_at);
    landmark.linearized_at = seen.point;
    jacobian.Add(landmark.first, kRobot, seen.by_pose);
    jacobian.Add(landmark.first, landmark.first, seen.by_point);
  }
  robot_linearized_at_.setZero();
  filter_.Transform(std::move(mean), jacobian.Build(), noise.Build());
  filter_.Keep(n, 3);
}

Rigid2 CeilingFilter::MapFromAnchor(int anchor) {
  const Eigen::VectorXd& kept = filter_.Kept();
  return ToRigid2(3 * anchor < kept.size() ? Eigen::Vector3d(kept.segment<3>(3 * anchor))
                                           : Eigen::Vector3d(filter_.Active().segment<3>(kAnchor)));
}

Eigen::Matrix3d CeilingFilter::AnchorCovariance(int anchor) {
  const Eigen::MatrixXd& kept = filter_.KeptCovariance();
  if (3 * anchor < kept.rows()) return kept.block<3, 3>(3 * anchor, 3 * anchor);
  return filter_.ActiveCovariance().block<3, 3>(kAnchor, kAnchor);
}

Eigen::Matrix3d CeilingFilter::RelativeCovariance(int anchor) {
  const ComposedPose seen =
      Between(filter_.Active().segment<3>(kAnchor), filter_.Kept().segment<3>(3 * anchor));
  const Eigen::Matrix3d cross = filter_.CrossCovariance().block<3, 3>(kAnchor, 3 * anchor);
  const Eigen::Matrix3d mixed = seen.by_first * cross * seen.by_second.transpose();
  return seen.by_first * filter_.ActiveCovariance().block<3, 3>(kAnchor, kAnchor) *
             seen.by_first.transpose() +
         seen.by_second * AnchorCovariance(anchor) * seen.by_second.transpose() + mixed +
         mixed.transpose();
}

Innovation CeilingFilter::CloseLoop(int anchor,
                                    const Rigid2& last_from_anchor,
                                    const Eigen::Matrix3d& covariance) {
  const ComposedPose seen =
      Between(filter_.Active().segment<3>(kAnchor), filter_.Kept().segment<3>(3 * anchor));
  Eigen::Vector3d residual = ToVector(last_from_anchor) - seen.pose;
  residual.z() = WrapAngle_rad(residual.z());
  // Residuals of unit variance.
  const Eigen::Matrix3d whiten = covariance.llt().matrixL().solve(Eigen::Matrix3d::Identity());
  SparseRowsBuilder active(3, filter_.NumActive()), kept(3, filter_.NumKept());
  active.Add(0, kAnchor, whiten * seen.by_first);
  kept.Add(0, 3 * anchor, whiten * seen.by_second);
  return filter_.Update({active.Build(), whiten * residual, Eigen::Vector3d::Ones()}, kept.Build());
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
