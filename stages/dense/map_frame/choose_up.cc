// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/choose_up.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "stages/dense/map_frame/up_candidates.h"

namespace nightmap {
namespace {

constexpr std::size_t kMaxPatches = 5000;  // more do not change shares of the area
constexpr double kMaxOdds = 1e6;

double Exponential(double value, double mean) { return std::exp(-value / mean) / mean; }
double Bell(double value, double sigma) { return std::exp(-0.5 * std::pow(value / sigma, 2)); }

// How a camera without a stated mount is held: x forward, y left, z up of the robot that it is.
struct Hold {
  double roll_rad;  // of up about x, from z towards y
  double share;     // of recordings
};
constexpr std::array<Hold, 4> kHolds = {{{0, 0.9},
                                         {std::numbers::pi / 2, 0.04},
                                         {-std::numbers::pi / 2, 0.04},
                                         {std::numbers::pi, 0.01}}};
constexpr double kElse = 1e-3;
constexpr double kMeanPitch_rad = -0.1;  // cameras look down rather than up
constexpr double kPitchSigma_rad = 0.5;
constexpr double kRollSigma_rad = 0.25;
constexpr double kMountSigma_rad = 0.4;  // of a robot with a tilted camera, or a hand

double LogAttitude(const Eigen::Vector3d& up_in_robot, bool is_mount_stated) {
  if (is_mount_stated) {
    return std::log(kElse +
                    Bell(Angle_rad(up_in_robot, Eigen::Vector3d::UnitZ()), kMountSigma_rad));
  }
  const double pitch_rad = std::asin(std::clamp(up_in_robot.x(), -1.0, 1.0));
  const double roll_rad = std::atan2(up_in_robot.y(), up_in_robot.z());
  const double roll_sigma_rad = kRollSigma_rad / std::max(0.2, std::cos(pitch_rad));
  double density = kElse;
  for (const Hold& hold : kHolds) {
    const double off_rad = std::remainder(roll_rad - hold.roll_rad, 2 * std::numbers::pi);
    density += hold.share * Bell(off_rad, roll_sigma_rad) *
               Bell(pitch_rad - kMeanPitch_rad, kPitchSigma_rad);
  }
  return std::log(density);
}

// About the variance of up, as the robot sees it: 1 - |mean| is half of it.
double LogTurns(double length_of_mean) {
  constexpr double kSigma_rad = 0.2;
  constexpr double kIndependentLooks = 2;
  return std::max(-15.0, -kIndependentLooks * (1 - length_of_mean) / (kSigma_rad * kSigma_rad));
}

// Those who walk or drive go level; within its reach an arm moves a camera any way.
// `climb`: the share of the squared steps that goes along up.
double LogWay(double climb, double reach_m) {
  constexpr double kArm_m = 1;
  return reach_m < kArm_m ? 0 : std::log(0.5 * Exponential(climb, 0.05) + 0.5);
}

struct Shares {             // of the area
  double facing = 0;        // up, as floors and tables
  double averted = 0;       // down, as ceilings
  double undersides = 0;    // down, and clearly below the highest of these
  double right_angled = 0;  // to up
};

// `down`: height and area of what is averted.
double UndersidesOf(std::vector<std::pair<double, double>> down) {
  constexpr double kCeiling_m = 0.4;  // slope, steps and drift
  if (down.empty()) return 0;
  std::ranges::sort(down);
  const double ceiling_m = down[down.size() * 95 / 100].first;
  double area_m2 = 0;
  for (const auto& [height_m, patch_m2] : down) {
    if (height_m < ceiling_m - kCeiling_m) area_m2 += patch_m2;
  }
  return area_m2;
}

Shares SharesOf(const std::vector<SurfacePatch>& patches, const Eigen::Vector3d& up) {
  constexpr double kLevel = 0.985, kWall = 0.1;  // cosines
  double facing_m2 = 0, walls_m2 = 0, averted_m2 = 0, total_m2 = 1e-9;
  std::vector<std::pair<double, double>> down;
  for (const SurfacePatch& patch : patches) {
    const double cosine = patch.normal.dot(up);
    total_m2 += patch.area_m2;
    if (cosine > kLevel) facing_m2 += patch.area_m2;
    if (std::abs(cosine) < kWall) walls_m2 += patch.area_m2;
    if (cosine > -kLevel) continue;
    averted_m2 += patch.area_m2;
    down.emplace_back(up.dot(patch.point), patch.area_m2);
  }
  return {facing_m2 / total_m2,
          averted_m2 / total_m2,
          UndersidesOf(std::move(down)) / total_m2,
          (facing_m2 + averted_m2 + walls_m2) / total_m2};
}

// How much likelier a share is if the surface is in view with that probability (then any share is
// as likely), than for a direction that is not up.
double LogInView(double share, double probability, double mean_out_of_view) {
  const double of_up = (1 - probability) * Exponential(share, mean_out_of_view) + probability * 1.5;
  return std::log(of_up / (0.7 * Exponential(share, 0.03) + 0.6));
}

// pitch_rad: by how much the cameras look up. Half of a usual picture's height is 0.4 rad.
double LogSurfaces(const Shares& shares, double pitch_rad) {
  const auto in_view = [](double above_rad) {
    return 0.03 + 0.94 / (1 + std::exp(-above_rad / 0.12));
  };
  constexpr double kUsual = 0.5;  // of the area is at right angles
  return LogInView(shares.facing, in_view(0.25 - pitch_rad), 0.02) +
         LogInView(shares.averted, in_view(pitch_rad - 0.2), 0.01) +
         LogInView(shares.undersides, 0.02, 0.01) +
         20 * (std::min(shares.right_angled, kUsual) - kUsual);
}

double MeanPitch_rad(const std::vector<Rigid3>& given_from_cameras, const Eigen::Vector3d& up) {
  double sum = 0;
  for (const Rigid3& pose : given_from_cameras) {
    sum += up.dot(pose.rotation * Eigen::Vector3d::UnitZ());
  }
  return std::asin(std::clamp(sum / static_cast<double>(given_from_cameras.size()), -1.0, 1.0));
}

Eigen::Vector3d MeanInRobot(const std::vector<Rigid3>& given_from_robots,
                            const Eigen::Vector3d& up) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rigid3& pose : given_from_robots) sum += pose.rotation.conjugate() * up;
  return sum / static_cast<double>(given_from_robots.size());
}

double ClimbAlong(const std::vector<Rigid3>& given_from_robots, const Eigen::Vector3d& up) {
  double along = 0, all = 0;
  for (std::size_t i = 1; i < given_from_robots.size(); ++i) {
    const Eigen::Vector3d step =
        given_from_robots[i].translation - given_from_robots[i - 1].translation;
    along += std::pow(step.dot(up), 2);
    all += step.squaredNorm();
  }
  return all > 0 ? along / all : 1;
}

// The largest distance from the mean position.
double Reach_m(const std::vector<Rigid3>& given_from_robots) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Rigid3& pose : given_from_robots) sum += pose.translation;
  const Eigen::Vector3d mean = sum / static_cast<double>(given_from_robots.size());
  double reach_m = 0;
  for (const Rigid3& pose : given_from_robots) {
    reach_m = std::max(reach_m, (pose.translation - mean).norm());
  }
  return reach_m;
}

std::string InWords(const Eigen::Vector3d& in_robot, bool is_mount_stated) {
  Eigen::Index axis = 0;
  in_robot.cwiseAbs().maxCoeff(&axis);
  const bool is_along = in_robot[axis] > 0;
  if (is_mount_stated)
    return fmt::format("the robot's {}{} axis", is_along ? "" : "-", "xyz"[axis]);
  constexpr const char* kWords[3][2] = {
      {"behind the camera, which looks down", "ahead of the camera, which looks up"},
      {"the right of the picture", "the left of the picture"},
      {"the bottom of the picture", "the top of the picture"}};
  return kWords[axis][is_along ? 1 : 0];
}

std::vector<SurfacePatch> Thinned(const std::vector<SurfacePatch>& patches) {
  std::vector<SurfacePatch> some;
  const std::size_t step = patches.size() / kMaxPatches + 1;
  for (std::size_t i = 0; i < patches.size(); i += step) some.push_back(patches[i]);
  return some;
}

}  // namespace

UpChoice ChooseUp(const std::vector<SurfacePatch>& patches,
                  const std::vector<Rigid3>& given_from_cameras,
                  const std::vector<Rigid3>& given_from_robots,
                  bool is_mount_stated,
                  const Eigen::Vector3d& guess) {
  const auto some = Thinned(patches);
  const double reach_m = Reach_m(given_from_robots);
  const auto candidates = UpCandidates(some, given_from_robots, guess);
  std::vector<std::pair<double, std::size_t>> scores;
  std::vector<Eigen::Vector3d> in_robot;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    in_robot.push_back(MeanInRobot(given_from_robots, candidates[i]));
    const double length = in_robot.back().norm();
    const double log_odds = LogAttitude(in_robot.back() / std::max(length, 1e-9), is_mount_stated) +
                            LogTurns(length) +
                            LogWay(ClimbAlong(given_from_robots, candidates[i]), reach_m) +
                            LogSurfaces(SharesOf(some, candidates[i]),
                                        MeanPitch_rad(given_from_cameras, candidates[i]));
    scores.emplace_back(-log_odds, i);
  }
  std::ranges::sort(scores);
  const std::size_t best = scores[0].second;
  UpChoice choice{
      candidates[best], best == 0, kMaxOdds, InWords(in_robot[best], is_mount_stated), ""};
  if (scores.size() < 2) return choice;
  choice.odds = std::min(kMaxOdds, std::exp(scores[1].first - scores[0].first));
  const std::size_t next = scores[1].second;
  choice.next_direction =
      fmt::format("{}, {:.0f} deg from it",
                  InWords(in_robot[next], is_mount_stated),
                  Angle_rad(candidates[best], candidates[next]) * 180 / std::numbers::pi);
  return choice;
}

}  // namespace nightmap
