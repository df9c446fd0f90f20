// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/sum_up_odometry.h"

#include <cmath>

#include "pipeline/base/median.h"
#include "pipeline/recording/wheel_counts.h"

namespace nightmap {
namespace {

constexpr double kTimesUsualStep = 10;  // farther, a counter jumps

// The robot turns evenly while it drives, so it moves along the mean of its headings.
Eigen::Vector3d Moved(const Eigen::Vector3d& pose, double distance_m, double turn_rad) {
  const double heading_rad = pose[2] + turn_rad / 2;
  return pose + Eigen::Vector3d(distance_m * std::cos(heading_rad),
                                distance_m * std::sin(heading_rad),
                                turn_rad);
}

// The counts of one wheel, and whether a step of them is far longer than steps are.
class Wheel {
 public:
  Wheel(const std::vector<SignalSample>& samples, Eigen::Index column) {
    for (const SignalSample& sample : samples) counts_.push_back(sample.value[column]);
    counts_ = UnwrapCounts(std::move(counts_));
    std::vector<double> steps;
    for (std::size_t i = 1; i < counts_.size(); ++i) {
      if (Step(i) != 0) steps.push_back(std::abs(Step(i)));
    }
    longest_usual_ = kTimesUsualStep * Median(steps);
  }

  double Step(std::size_t i) const { return counts_[i] - counts_[i - 1]; }
  bool Jumps(std::size_t i) const { return std::abs(Step(i)) > longest_usual_; }

 private:
  std::vector<double> counts_;
  double longest_usual_ = 0;
};

void SumUpTicks(const SensorConfig& sensor, std::vector<SignalSample>* samples) {
  const Wheel left(*samples, 0), right(*samples, 1);
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < samples->size(); ++i) {
    Eigen::Vector3d& value = (*samples)[i].value;
    if (value.head<2>().isZero(0) && i > 0 && (left.Jumps(i) || right.Jumps(i))) {
      pose.setZero();
    } else if (i > 0) {
      const double left_m = sensor.m_per_tick * left.Step(i);
      const double right_m = sensor.m_per_tick * right.Step(i);
      pose = Moved(pose, (left_m + right_m) / 2, (right_m - left_m) / sensor.wheel_base_m);
    }
    value = pose;
  }
}

}  // namespace

void SumUpOdometry(const SensorConfig& sensor, std::vector<SignalSample>* samples) {
  if (sensor.measures == "ticks") return SumUpTicks(sensor, samples);
  if (sensor.measures != "motion") return;
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();
  for (SignalSample& sample : *samples) {
    sample.value = pose = Moved(pose, sample.value[0], sample.value[1]);
  }
}

}  // namespace nightmap
