// SPDX-License-Identifier: Apache-2.0
// The unit of the times in the lists of a recording: `time_unit` of its table in the site config.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/io/trajectory_io.h"

namespace nightmap {

constexpr double kMaxFrameStep_s = 10;          // median from line to line, also of odometry
constexpr std::size_t kMaxTimesToJudge = 1000;  // the first of a file

// The unit that `time_unit` of a table states: s, ms, us or ns. Empty: nothing is stated, seconds.
TimeUnit UnitOf(const std::string& time_unit);

// The unit "ms", "us" or "ns" that times look like which cannot be seconds; empty when they can.
// They cannot when all are too late for CheckedTime_ns, or when the median of at least 10 steps is
// above max_step_s: a damaged line does not decide.
std::string UnitLike(const std::vector<double>& times, double max_step_s);
// Likewise for the times that begin the lines of a file. Throws DataError when it cannot be read.
std::string UnitLike(const std::filesystem::path& path, double max_step_s);

// Throws DataError when `unit_like` is not empty. `source` is the file:line of the table that lacks
// its time_unit.
void DemandSeconds(const std::string& unit_like,
                   const std::filesystem::path& path,
                   const std::string& source);

}  // namespace nightmap
