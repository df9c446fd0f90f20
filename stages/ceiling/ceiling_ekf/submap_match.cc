// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/submap_match.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace nightmap {
namespace {

// Bits of 256 in which the descriptors of one landmark may differ.
constexpr int kMaxDescriptorBits = 70;
// Difference in height between a landmark and itself, met again.
constexpr double kMaxHeightDifference_m = 0.12;
constexpr double kGate = 16;            // squared sigmas, of a pair
constexpr double kPoseGate = 32;        // squared sigmas, of a pose
constexpr std::size_t kMaxSeeds = 250;  // pairs that hypotheses are made of
constexpr double kMinBase_m = 0.4;      // between the two pairs of a hypothesis
// Poses farther apart are another place.
constexpr double kRival_m = 0.2;
constexpr double kRival_rad = 0.15;
// Error that the landmarks of two submaps may have in common.
constexpr double kFloor_m = 0.01;
constexpr double kFloor_rad = 0.003;
constexpr int kNumRefinements = 5;

struct Pair {
  int now = 0;
  int then = 0;
  int num_bits = 0;
};

int Distance_bits(const SubmapLandmark& a, const SubmapLandmark& b) {
  int num = 0;
  for (std::size_t i = 0; i < a.descriptor.size(); ++i) {
    num += std::popcount(static_cast<unsigned>(a.descriptor[i] ^ b.descriptor[i]));
  }
  return num;
}

class Matcher {
 public:
  Matcher(const SubmapMatchOptions& options,
          const std::vector<SubmapLandmark>& now,
          const std::vector<SubmapLandmark>& then,
          const Rigid2& expected,
          const Eigen::Matrix3d& covariance)
      : options_(options), now_(now), then_(then), expected_(expected), factor_(covariance) {
    FindPairs(covariance);
  }

  std::optional<SubmapMatch> Match() const {
    Rigid2 best;
    int num_best = 0;
    std::vector<std::pair<Rigid2, int>> hypotheses;
    const std::size_t num_seeds = std::min(pairs_.size(), kMaxSeeds);
    for (std::size_t i = 0; i < num_seeds; ++i) {
      for (std::size_t j = i + 1; j < num_seeds; ++j) {
        const auto pose = PoseOf(pairs_[i], pairs_[j]);
        if (!pose || !IsExpected(*pose)) continue;
        const int num = static_cast<int>(Agreeing(*pose).size());
        if (num < options_.min_pairs / 2) continue;
        hypotheses.emplace_back(*pose, num);
        if (num <= num_best) continue;
        num_best = num;
        best = *pose;
      }
    }
    if (num_best < options_.min_pairs / 2) return std::nullopt;
    SubmapMatch match = Refine(best);
    if (static_cast<int>(match.pairs.size()) < options_.min_pairs) return std::nullopt;
    int num_rival = 0;
    for (const auto& [pose, num] : hypotheses) {
      const Rigid2 off = match.now_from_then.Inverse() * pose;
      // About the landmarks, not about the anchor, which may be far from them.
      const double off_m = (pose * Middle(match) - match.now_from_then * Middle(match)).norm();
      if (off_m < kRival_m && std::abs(off.heading_rad) < kRival_rad) continue;
      num_rival = std::max(num_rival, num);
    }
    const auto limit = options_.max_rival_ratio * static_cast<double>(match.pairs.size());
    if (num_rival >= limit || !IsExpected(match.now_from_then)) return std::nullopt;
    return match;
  }

 private:
  Eigen::Vector2d Now(int i) const { return now_[static_cast<std::size_t>(i)].position.head<2>(); }
  Eigen::Vector2d Then(int i) const {
    return then_[static_cast<std::size_t>(i)].position.head<2>();
  }

  void FindPairs(const Eigen::Matrix3d& covariance) {
    for (int i = 0; i < static_cast<int>(now_.size()); ++i) {
      for (int j = 0; j < static_cast<int>(then_.size()); ++j) {
        const SubmapLandmark& a = now_[static_cast<std::size_t>(i)];
        const SubmapLandmark& b = then_[static_cast<std::size_t>(j)];
        if (std::abs(a.position.z() - b.position.z()) > kMaxHeightDifference_m) continue;
        const Eigen::Vector2d moved = expected_ * b.position.head<2>();
        const Eigen::Vector2d arm = moved - expected_.translation;
        Eigen::Matrix<double, 2, 3> by_pose;
        by_pose << 1, 0, -arm.y(), 0, 1, arm.x();
        const Eigen::Matrix2d variance =
            by_pose * covariance * by_pose.transpose() +
            std::pow(options_.max_distance_m, 2) * Eigen::Matrix2d::Identity();
        const Eigen::Vector2d off = a.position.head<2>() - moved;
        if (off.dot(variance.llt().solve(off)) > kGate) continue;
        const int num_bits = Distance_bits(a, b);
        if (num_bits <= kMaxDescriptorBits) pairs_.push_back({i, j, num_bits});
      }
    }
    std::ranges::stable_sort(pairs_, {}, &Pair::num_bits);
  }

  std::optional<Rigid2> PoseOf(const Pair& a, const Pair& b) const {
    const Eigen::Vector2d base_now = Now(b.now) - Now(a.now);
    const Eigen::Vector2d base_then = Then(b.then) - Then(a.then);
    if (base_then.norm() < kMinBase_m) return std::nullopt;
    if (std::abs(base_now.norm() - base_then.norm()) > options_.max_distance_m) {
      return std::nullopt;
    }
    Rigid2 pose;
    pose.heading_rad = WrapAngle_rad(std::atan2(base_now.y(), base_now.x()) -
                                     std::atan2(base_then.y(), base_then.x()));
    const Eigen::Vector2d middle_then = (Then(a.then) + Then(b.then)) / 2;
    pose.translation =
        (Now(a.now) + Now(b.now)) / 2 - Eigen::Rotation2Dd(pose.heading_rad) * middle_then;
    return pose;
  }

  bool IsExpected(const Rigid2& pose) const {
    Eigen::Vector3d off;
    off << pose.translation - expected_.translation,
        WrapAngle_rad(pose.heading_rad - expected_.heading_rad);
    return off.dot(factor_.solve(off)) < kPoseGate;
  }

  // One pair for each landmark at most, best looking first.
  std::vector<std::pair<int, int>> Agreeing(const Rigid2& pose) const {
    std::vector<char> is_now_used(now_.size()), is_then_used(then_.size());
    std::vector<std::pair<int, int>> agreeing;
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(pose.heading_rad).toRotationMatrix();
    for (const Pair& pair : pairs_) {
      const auto i = static_cast<std::size_t>(pair.now);
      const auto j = static_cast<std::size_t>(pair.then);
      if (is_now_used[i] || is_then_used[j]) continue;
      const Eigen::Vector2d off = Now(pair.now) - turn * Then(pair.then) - pose.translation;
      if (off.squaredNorm() > options_.max_distance_m * options_.max_distance_m) continue;
      is_now_used[i] = is_then_used[j] = 1;
      agreeing.emplace_back(pair.now, pair.then);
    }
    return agreeing;
  }

  Eigen::Vector2d Middle(const SubmapMatch& match) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const auto& [now, then] : match.pairs) sum += Then(then);
    return sum / static_cast<double>(match.pairs.size());
  }

  // Least squares over the agreeing pairs, which are found anew.
  SubmapMatch Refine(Rigid2 pose) const {
    SubmapMatch match;
    for (int round = 0; round < kNumRefinements; ++round) {
      match.pairs = Agreeing(pose);
      Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
      Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
      double squared = 0;
      for (const auto& [now, then] : match.pairs) {
        const Eigen::Vector2d arm = Eigen::Rotation2Dd(pose.heading_rad) * Then(then);
        const Eigen::Vector2d off = Now(now) - arm - pose.translation;
        Eigen::Matrix<double, 2, 3> jacobian;
        jacobian << 1, 0, -arm.y(), 0, 1, arm.x();
        normal += jacobian.transpose() * jacobian;
        gradient += jacobian.transpose() * off;
        squared += off.squaredNorm();
      }
      if (match.pairs.size() < 2) break;
      const Eigen::Vector3d step = normal.llt().solve(gradient);
      pose.translation += step.head<2>();
      pose.heading_rad = WrapAngle_rad(pose.heading_rad + step.z());
      match.now_from_then = pose;
      const double variance = squared / static_cast<double>(2 * match.pairs.size());
      match.covariance = std::max(variance, kFloor_m * kFloor_m) * normal.inverse();
      // The floor is that of the place of the landmarks.
      const Eigen::Vector2d arm = Eigen::Rotation2Dd(pose.heading_rad) * Middle(match);
      Eigen::Matrix3d by_common = Eigen::Matrix3d::Identity();
      by_common(0, 2) = arm.y();
      by_common(1, 2) = -arm.x();
      const Eigen::Vector3d floor(kFloor_m, kFloor_m, kFloor_rad);
      match.covariance += by_common * floor.cwiseAbs2().asDiagonal() * by_common.transpose();
    }
    return match;
  }

  const SubmapMatchOptions& options_;
  const std::vector<SubmapLandmark>& now_;
  const std::vector<SubmapLandmark>& then_;
  Rigid2 expected_;
  Eigen::LLT<Eigen::Matrix3d> factor_;
  std::vector<Pair> pairs_;  // best looking first
};

}  // namespace

std::optional<SubmapMatch> MatchSubmaps(const SubmapMatchOptions& options,
                                        const std::vector<SubmapLandmark>& now,
                                        const std::vector<SubmapLandmark>& then,
                                        const Rigid2& expected,
                                        const Eigen::Matrix3d& covariance) {
  return Matcher(options, now, then, expected, covariance).Match();
}

}  // namespace nightmap
