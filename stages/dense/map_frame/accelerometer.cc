// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/accelerometer.h"

#include <algorithm>
#include <optional>

#include "pipeline/base/input_error.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {
namespace {

// Mean of the samples around a time; nothing when there are none.
std::optional<Eigen::Vector3d> MeanAcceleration(const std::vector<AccelerometerSample>& samples,
                                                std::int64_t time_ns) {
  constexpr std::int64_t kWindow_ns = 100'000'000;
  const auto begin =
      std::ranges::lower_bound(samples, time_ns - kWindow_ns, {}, &AccelerometerSample::time_ns);
  const auto end =
      std::ranges::upper_bound(samples, time_ns + kWindow_ns, {}, &AccelerometerSample::time_ns);
  if (begin == end) return std::nullopt;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (auto sample = begin; sample != end; ++sample) sum += sample->acceleration_m_per_s2;
  return sum / static_cast<double>(end - begin);
}

}  // namespace

std::vector<AccelerometerSample> ReadAcceleration(const std::filesystem::path& path) {
  std::vector<AccelerometerSample> samples;
  const auto signals = ReadSignals(path, SignalKind::kAcceleration);
  if (signals.empty()) return samples;
  for (const SignalSample& sample : signals.front().samples) {
    samples.push_back({sample.time_ns, signals.front().robot_from_sensor.rotation * sample.value});
  }
  return samples;
}

Eigen::Vector3d UpFromAccelerometer(const std::vector<AccelerometerSample>& samples,
                                    const std::vector<StampedPose>& keyframes) {
  constexpr double kMinMean_m_per_s2 = 5;  // half of gravity
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const StampedPose& keyframe : keyframes) {
    const auto mean = MeanAcceleration(samples, keyframe.time_ns);
    if (!mean) continue;
    sum += keyframe.pose.rotation * *mean;
    ++count;
  }
  const std::vector<InputName> input = {{"acceleration"}};
  if (count == 0) {
    throw InputError(input,
                     InputError::Remedy::kInText,
                     "no sample within 0.1 s of a keyframe; correct the times of its recording, or "
                     "leave its [[signal]] out of the site config, and run make");
  }
  if (!(sum.norm() / count >= kMinMean_m_per_s2)) {
    throw InputError(input,
                     InputError::Remedy::kInText,
                     "the mean over {} keyframes is {:.2f} m/s2, not gravity's 9.8; correct "
                     "robot_from_sensor and robot_from_camera in the site config, or leave its "
                     "[[signal]] out, and run make",
                     count,
                     sum.norm() / count);
  }
  return sum.normalized();
}

}  // namespace nightmap
