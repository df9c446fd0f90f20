// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/up_candidates.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

namespace nightmap {
namespace {

constexpr int kMaxDirections = 6;
constexpr double kMinDirectionShare = 0.03;  // of the area that no other direction explains
constexpr double kDirectionWidth_rad = 0.26;
constexpr std::size_t kSeeds = 60;
constexpr double kMaxTurn_rad = 0.45;  // of an alignment

double AbsCosine(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return std::abs(a.dot(b)); }

// The area that lies along a direction, of the patches that are left.
double AreaAlong(const std::vector<SurfacePatch>& patches,
                 const std::vector<bool>& is_left,
                 const Eigen::Vector3d& direction) {
  double area_m2 = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    if (is_left[i] && AbsCosine(patches[i].normal, direction) > std::cos(kDirectionWidth_rad)) {
      area_m2 += patches[i].area_m2;
    }
  }
  return area_m2;
}

// The mean axis of the patches along a direction, with a shrinking window.
Eigen::Vector3d MeanAxis(const std::vector<SurfacePatch>& patches, Eigen::Vector3d axis) {
  for (const double window_rad : {0.3, 0.2, 0.1}) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const SurfacePatch& patch : patches) {
      const double cosine = patch.normal.dot(axis);
      if (std::abs(cosine) < std::cos(window_rad)) continue;
      sum += (cosine > 0 ? patch.area_m2 : -patch.area_m2) * patch.normal;
    }
    if (sum.norm() > 0) axis = sum.normalized();
  }
  return axis;
}

// Axes along which most of the surface's normals lie, the largest first.
std::vector<Eigen::Vector3d> MainDirections(const std::vector<SurfacePatch>& patches) {
  std::vector<bool> is_left(patches.size(), true);
  std::vector<Eigen::Vector3d> directions;
  double total_m2 = 0;
  for (const SurfacePatch& patch : patches) total_m2 += patch.area_m2;
  while (directions.size() < kMaxDirections) {
    std::vector<std::size_t> left;
    for (std::size_t i = 0; i < patches.size(); ++i) {
      if (is_left[i]) left.push_back(i);
    }
    double largest_m2 = kMinDirectionShare * total_m2;
    std::size_t best = patches.size();
    for (std::size_t k = 0; k < left.size(); k += left.size() / kSeeds + 1) {
      const double area_m2 = AreaAlong(patches, is_left, patches[left[k]].normal);
      if (area_m2 <= largest_m2) continue;
      largest_m2 = area_m2;
      best = left[k];
    }
    if (best == patches.size()) break;
    directions.push_back(MeanAxis(patches, patches[best].normal));
    for (const std::size_t i : left) {
      const double cosine = AbsCosine(patches[i].normal, directions.back());
      is_left[i] = i != best && cosine < std::cos(kDirectionWidth_rad);
    }
  }
  return directions;
}

// The direction that changes least as the robot sees it: that about which it turned. Nothing where
// it turned too little, or about several axes.
std::optional<Eigen::Vector3d> TurningAxis(const std::vector<Rigid3>& given_from_robots) {
  constexpr double kMinVariance = 0.01;  // of the other directions; half of a squared angle
  constexpr double kMinRatio = 4;        // to the variance of the axis itself
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Rigid3& pose : given_from_robots) sum += pose.rotation.toRotationMatrix().transpose();
  const Eigen::Matrix3d mean = sum / static_cast<double>(given_from_robots.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(mean.transpose() * mean);
  const auto variance = [&](int i) {
    return 1 - std::sqrt(std::max(0.0, solver.eigenvalues()[i]));
  };
  if (variance(1) < std::max(kMinVariance, kMinRatio * variance(2))) return std::nullopt;
  return solver.eigenvectors().col(2);
}

}  // namespace

Eigen::Vector3d AlignToSurfaces(const std::vector<SurfacePatch>& patches,
                                const Eigen::Vector3d& up) {
  Eigen::Vector3d aligned = up;
  for (const double tolerance_rad : {0.3, 0.2, 0.12, 0.08, 0.05}) {
    Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
    for (const SurfacePatch& patch : patches) {
      const double cosine = AbsCosine(patch.normal, aligned);
      const bool is_wall = cosine < std::sin(tolerance_rad);
      if (!is_wall && cosine < std::cos(tolerance_rad)) continue;
      moment +=
          (is_wall ? patch.area_m2 : -patch.area_m2) * patch.normal * patch.normal.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moment);
    const Eigen::Vector3d axis = solver.eigenvectors().col(0);
    if (AbsCosine(axis, aligned) < std::cos(tolerance_rad)) break;
    aligned = axis.dot(aligned) < 0 ? Eigen::Vector3d(-axis) : axis;
  }
  return Angle_rad(aligned, up) < kMaxTurn_rad ? aligned : up;
}

std::vector<Eigen::Vector3d> UpCandidates(const std::vector<SurfacePatch>& patches,
                                          const std::vector<Rigid3>& given_from_robots,
                                          const Eigen::Vector3d& first) {
  std::vector<Eigen::Vector3d> axes = {first};
  if (const auto axis = TurningAxis(given_from_robots)) axes.push_back(*axis);
  const auto directions = MainDirections(patches);
  axes.insert(axes.end(), directions.begin(), directions.end());
  for (std::size_t i = 0; i < directions.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector3d third = directions[i].cross(directions[j]);
      if (third.norm() > 0.9) axes.emplace_back(third.normalized());
    }
  }
  std::vector<Eigen::Vector3d> candidates = {first};
  for (const Eigen::Vector3d& axis : axes) {
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector3d candidate = AlignToSurfaces(patches, sign * axis);
      const bool is_new = std::ranges::all_of(candidates, [&](const Eigen::Vector3d& other) {
        return Angle_rad(candidate, other) > kSameUp_rad;
      });
      if (is_new) candidates.push_back(candidate);
    }
  }
  return candidates;
}

}  // namespace nightmap
