// SPDX-License-Identifier: Apache-2.0
// The landmarks of CeilingFilter, and the clones that they are first seen from.
#include <algorithm>
#include <cmath>

#include "pipeline/ceiling/planar_pose.h"
#include "stages/ceiling/ceiling_ekf/ceiling_filter.h"
#include "stages/ceiling/ceiling_ekf/disparity_depth.h"
#include "stages/ceiling/ceiling_ekf/sparse_rows.h"

namespace nightmap {
namespace {

// A new landmark's depth is not known: this is its deviation, relative to it.
constexpr double kDepthSigma = 10;
// A disparity is so many of its deviations at least.
constexpr double kMinDisparity_sigmas = 3;

}  // namespace

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
  Insert(
      {track_id, n, camera_.PointAt(then.linearized_at, then_view.tilt_rad, from, *depth_m).point});
  if (Gates({{track_id, now}})[0] > gate) {
    RemoveLandmarks({track_id});
    return false;
  }
  Observe({{track_id, now}});
  return true;
}

bool CeilingFilter::AddLandmarkByDisparity(std::int64_t track_id,
                                           std::int64_t clone_id,
                                           const Eigen::Vector2d& from,
                                           const Eigen::Vector2d& now) {
  const Eigen::VectorXd& state = filter_.Active();
  const Eigen::Index n = filter_.NumActive();
  const Eigen::Index clone = FindClone(clone_id).first;
  const Eigen::Vector3d robot = state.segment<3>(kRobot);
  const auto depth = DepthByDisparity(camera_, state.segment<3>(clone), from, robot, now);
  if (!depth) return false;
  // Neither is told by the state: the publication knows no tilt.
  Eigen::Matrix<double, 1, 6> by_noise;
  by_noise << noise_.vibration_sigma_rad * depth->by_first.tilt,
      noise_.vibration_sigma_rad * depth->by_second.tilt,
      noise_.pixel_sigma_px * depth->by_first.pixel;
  const Eigen::RowVector2d by_now = noise_.pixel_sigma_px * depth->by_second.pixel;
  const double sigma_m = std::hypot(by_noise.norm(), by_now.norm());
  if (kMinDisparity_sigmas * sigma_m > depth->depth_m) return false;

  const Eigen::Vector2d tilt_rad = state.segment<2>(kVibration) + state.segment<2>(kMounting);
  const UpwardCamera::RayPoint ray = camera_.PointAt(robot, tilt_rad, now, depth->depth_m);
  Eigen::VectorXd mean(n + kLandmarkSize);
  mean << state, ray.point;
  SparseRowsBuilder jacobian(n + kLandmarkSize, n), noise(n + kLandmarkSize, n + kLandmarkSize);
  jacobian.Identity(0, n);
  jacobian.Add(n, clone, ray.by_depth * depth->by_first.pose);
  jacobian.Add(n, kRobot, ray.by_pose + ray.by_depth * depth->by_second.pose);
  jacobian.Add(n, kVibration, ray.by_tilt);
  jacobian.Add(n, kMounting, ray.by_tilt);
  const Matrix32d by_pixel = noise_.pixel_sigma_px * ray.by_pixel + ray.by_depth * by_now;
  noise.Add(n, n, by_pixel * by_pixel.transpose());
  noise.Add(n, n, by_noise.squaredNorm() * ray.by_depth * ray.by_depth.transpose());
  filter_.Transform(std::move(mean), jacobian.Build(), noise.Build());
  Insert({track_id, n, camera_.PointAt(robot_linearized_at_, tilt_rad, now, depth->depth_m).point});
  return true;
}

void CeilingFilter::Insert(const Part& landmark) {
  landmarks_.insert(std::ranges::lower_bound(landmarks_, landmark.id, {}, &Part::id), landmark);
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

}  // namespace nightmap
