// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/odometry_units.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"

namespace nightmap {
namespace {

constexpr double kFastest_m_per_s = 10;  // no robot in a building is usually faster
constexpr double kMoving_m_per_s = 0.02;
constexpr double kFastest_rad_per_s = 10;
constexpr double kTurning_per_s = 0.5;  // rad or degrees
constexpr std::int64_t kWindow_ns = 1'000'000'000;
constexpr std::int64_t kLongestWindow_ns = 5'000'000'000;  // a pause is no window
constexpr std::size_t kMinWindows = 10;

constexpr double kMove_m = 0.05;  // from here on a motion has a direction
constexpr std::size_t kMinMoves = 20;
constexpr double kAgreeing = 0.9;      // of directions and headings as degrees
constexpr double kTimesTheSpread = 5;  // of them as rad

constexpr double kTurn_rad = 2 * std::numbers::pi;
constexpr double kDeg_rad = std::numbers::pi / 180;

// How well the headings at both ends of motions agree with their directions: 1 where all do, or
// all differ by the same.
class Agreement {
 public:
  explicit Agreement(double unit_rad) : unit_rad_(unit_rad) {}

  void Add(const Eigen::Vector3d& start, const Eigen::Vector3d& end) {
    const double turn_rad = std::remainder(unit_rad_ * (end.z() - start.z()), kTurn_rad);
    const double heading_rad = unit_rad_ * start.z() + turn_rad / 2;
    const double direction_rad = std::atan2(end.y() - start.y(), end.x() - start.x());
    sum_ += std::polar(1.0, 2 * (direction_rad - heading_rad));
    ++count_;
  }

  std::size_t Count() const { return count_; }
  double Value() const { return std::abs(sum_) / static_cast<double>(count_); }

 private:
  double unit_rad_;
  std::complex<double> sum_ = 0;
  std::size_t count_ = 0;
};

// Calls visit(start, end, passed_s) for windows of a second, one after the other.
template <typename Visit>
void VisitSeconds(const std::vector<SignalSample>& poses, const Visit& visit) {
  for (std::size_t start = 0, end = 0; end < poses.size(); ++end) {
    const std::int64_t passed_ns = poses[end].time_ns - poses[start].time_ns;
    if (passed_ns < kWindow_ns) continue;
    if (passed_ns <= kLongestWindow_ns) {
      visit(poses[start].value, poses[end].value, 1e-9 * static_cast<double>(passed_ns));
    }
    start = end;
  }
}

}  // namespace

double UsualSpeed_m_per_s(const std::vector<SignalSample>& poses) {
  std::vector<double> speeds;
  VisitSeconds(poses, [&](const Eigen::Vector3d& start, const Eigen::Vector3d& end, double s) {
    const double speed = (end - start).head<2>().norm() / s;
    if (speed > kMoving_m_per_s) speeds.push_back(speed);
  });
  return speeds.size() < kMinWindows ? 0 : Median(speeds);
}

bool SumsLookLikeDegrees(const std::vector<SignalSample>& poses) {
  std::size_t num_turning = 0, num_impossible = 0;
  VisitSeconds(poses, [&](const Eigen::Vector3d& start, const Eigen::Vector3d& end, double s) {
    const double speed = std::abs(end.z() - start.z()) / s;
    num_turning += speed > kTurning_per_s ? 1 : 0;
    num_impossible += speed > kFastest_rad_per_s ? 1 : 0;
  });
  return num_impossible >= kMinWindows && 4 * num_impossible > num_turning;
}

bool LookLikeDegrees(const std::vector<SignalSample>& poses) {
  const bool exceed_turn = std::ranges::any_of(
      poses, [](const SignalSample& pose) { return std::abs(pose.value.z()) > kTurn_rad; });
  if (!exceed_turn) return false;
  Agreement rad(1), deg(kDeg_rad);
  Eigen::Vector3d start = poses.front().value;
  for (const SignalSample& pose : poses) {
    const double way_m = (pose.value - start).head<2>().norm();
    if (way_m < kMove_m) continue;
    rad.Add(start, pose.value);
    deg.Add(start, pose.value);
    start = pose.value;
  }
  return rad.Count() >= kMinMoves && deg.Value() >= kAgreeing &&
         1 - rad.Value() > kTimesTheSpread * (1 - deg.Value());
}

void DemandUnits(const SensorConfig& sensor,
                 const std::vector<SignalSample>& poses,
                 const std::filesystem::path& path) {
  const double speed = UsualSpeed_m_per_s(poses);
  if (speed > kFastest_m_per_s) {
    const std::string remedy =
        sensor.measures == "ticks"
            ? "correct m_per_tick in its [[sensor]]"
            : fmt::format(
                  "write position_unit = \"mm\" in its [[sensor]], where that is {:.3g} "
                  "m/s, or \"cm\", where it is {:.3g} m/s",
                  1e-3 * speed / sensor.position_unit_m,
                  1e-2 * speed / sensor.position_unit_m);
    throw DataError(
        "{}: by the odometry of \"{}\" the robot usually drives {:.4g} m/s, which no robot does: "
        "{}; where the times of the file are wrong, correct them",
        path.string(),
        sensor.id,
        speed,
        remedy);
  }
  if (sensor.heading_unit_rad || sensor.measures == "ticks") return;
  if (sensor.measures == "motion" ? !SumsLookLikeDegrees(poses) : !LookLikeDegrees(poses)) return;
  throw DataError(
      "{}: the headings of \"{}\" are no radians, they look like degrees: write "
      "heading_unit = \"deg\" in its [[sensor]], or \"rad\" if they are radians",
      path.string(),
      sensor.id);
}

}  // namespace nightmap
