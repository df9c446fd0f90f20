// SPDX-License-Identifier: Apache-2.0
// Reads what the sensors beside the cameras measured, from the files that a site config names.
//
// A line is one sample. Time is in seconds (in nanoseconds in a csv column that ends in _ns).
//   text    blank-separated words, # comments: time and values, as TUM's accelerometer.txt
//   csv     a header, and the columns that `columns` names: time, then the values
//   carmen  a log of CARMEN; the lines that begin with `message`, other lines are passed over
// The values are: ax ay az (m/s2) of acceleration; x y heading (m, rad), or distance and heading
// change since the sample before, or the counts of the left and the right wheel, of odometry; the
// ranges (m) of a scan. Of CARMEN's laser messages odometry is the last pose: of FLASER and RLASER
// `odom_x odom_y odom_theta`, of ROBOTLASER1 the robot's.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/io/signals_io.h"
#include "pipeline/io/site_config.h"

namespace nightmap {

struct SensorSignals {
  std::vector<Signal> signals;        // one for each [[sensor]], in their order
  std::vector<std::string> problems;  // one for each line that was left out: file:line: reason
};

// Lines that are no sample, and samples whose time is not after that of the sample before, are left
// out with their reason. Throws DataError when a file cannot be read or holds no sample, and when
// more than max_failed_ratio of its lines are left out. Deterministic.
SensorSignals ReadSensorSignals(const SiteConfig& site,
                                const std::filesystem::path& data_root,
                                double max_failed_ratio);

// A sample as a line says it: odometry is not yet summed up. A DataError says what is wrong.
SignalSample ParseCarmenLine(const SensorConfig& sensor,
                             const std::vector<std::string_view>& words);
// `values` without the time.
SignalSample ParseValues(const SensorConfig& sensor,
                         std::int64_t time_ns,
                         const std::vector<std::string_view>& values);

}  // namespace nightmap
