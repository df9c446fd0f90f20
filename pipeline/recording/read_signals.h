// SPDX-License-Identifier: Apache-2.0
// Reads the measurements of sensors other than cameras from the files that a site config names.
//
// A line is one sample. Time is in seconds (in nanoseconds in a csv column that ends in _ns).
//   text    blank-separated words, # comments: time and values, as TUM's accelerometer.txt
//   csv     a header, and the columns that `columns` names: time, then the values; of a scan all
//           other columns
//   carmen  a log of CARMEN; uses the lines that begin with `message` and ignores the others
// The values are: for acceleration ax ay az (m/s2); for odometry x y heading (m, rad), or a
// quaternion qx qy qz qw instead of the heading and perhaps z before it, or distance and heading
// change since the previous sample, or the counts of the left and the right wheel; for a scan the
// ranges. In CARMEN's laser messages odometry is the last pose: for FLASER and RLASER `odom_x
// odom_y odom_theta`, for ROBOTLASER1 the robot's. A range that is NaN, infinite or below 0 is one
// that hit nothing.
//
// Clocks of logs jump. Scans and odometry whose times are a little before those of lines before
// keep their place: line_clock.h gives each line of a file one time, for all sensors that read it.
// The rule sees times only, so two files with the same stamps, as a log and a table made of it, get
// the same times.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/recording/finish_scans.h"
#include "pipeline/recording/signals_io.h"
#include "pipeline/recording/site_config.h"

namespace nightmap {

struct SensorSignals {
  std::vector<Signal> signals;                 // one per [[sensor]], in their order
  std::vector<std::string> problems;           // one per line that was left out: file:line: reason
  std::vector<std::size_t> num_in_line_order;  // per [[sensor]]: samples that got another time
  std::vector<FoundInScans> found_in_scans;    // per [[sensor]]
  std::vector<std::string> apart;  // what to say of odometry and scans that hardly overlap in time
};

// Leaves out, with their reason, lines that are no sample, samples whose time is not after the
// previous one and that do not keep their place, and scans that have far more or fewer beams than
// most of their file. Throws DataError when a file cannot be read or holds no sample, and when more
// than max_failed_ratio of its lines are left out. Deterministic.
SensorSignals ReadSensorSignals(const SiteConfig& site,
                                const std::filesystem::path& data_root,
                                double max_failed_ratio);

// Whether a line of CARMEN must end with its time, or may lack it and is not asked for it.
enum class LineTime { kNeeded, kIgnored };

// One sample of a line; odometry is not yet accumulated. Without its time, if that is ignored.
// Throws DataError with the reason.
SignalSample ParseCarmenLine(const SensorConfig& sensor,
                             LineTime line_time,
                             const std::vector<std::string_view>& words);
// One sample from `values`, which do not include the time.
SignalSample ParseValues(const SensorConfig& sensor,
                         std::int64_t time_ns,
                         const std::vector<std::string_view>& values);

}  // namespace nightmap
