// SPDX-License-Identifier: Apache-2.0
// frames/acceleration.h5, odometry.h5 and scans.h5: measurements of the sensors other than cameras.
// One file per kind holds all sensors of that kind, in the order of the site config.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/recording/signal_kinds.h"

namespace nightmap {

// The three values of a sample:
//   acceleration  m/s2 along the sensor's axes; at rest it is 9.8 upwards
//   odometry      x and y in metres and heading in rad (counter-clockwise) of the wheels' frame in
//                 a frame that drifts; turns are not wrapped away where a recording counts them
//   scan          angle of the first beam and from beam to beam in rad, counter-clockwise from the
//                 sensor's x, and the range in metres from which on nothing was hit; scans of one
//                 sensor may differ in all of them, and in their number of beams
struct SignalSample {
  std::int64_t time_ns = 0;
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  std::vector<float> ranges_m;  // of a scan, one for each beam
};

// The measurements of one sensor.
struct Signal {
  SignalKind kind = SignalKind::kAcceleration;
  std::string sensor_id;
  Rigid3 robot_from_sensor;
  std::vector<SignalSample> samples;  // times increase
  // A scan's time is that of its first beam; beam i of n is taken i/n of this later. 0: at once.
  double scan_duration_s = 0;
};

inline constexpr double kMaxScanDuration_s = 10;
// From here on a scanner hit nothing, unless it is stated.
inline constexpr double kMaxRangeUnlessStated_m = 80;

// `signals` are of one kind. Equal signals give equal bytes. Throws DataError.
void WriteSignals(const std::filesystem::path& path,
                  SignalKind kind,
                  const std::vector<Signal>& signals);

// Throws DataError naming file and field on another kind, sizes that do not add up, NaN, times that
// do not increase, or an invalid pose.
std::vector<Signal> ReadSignals(const std::filesystem::path& path, SignalKind kind);

}  // namespace nightmap
