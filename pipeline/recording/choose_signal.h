// SPDX-License-Identifier: Apache-2.0
// The one sensor of several that a job reads.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

// The scanner of this id; with an empty id the only one. `option` is the one that names it, for
// messages. Throws UsageError when the id names none, or is empty where there are several, and
// InputError of the port `scans` when nothing scans, or the sensor never did.
const Signal& ChooseScanner(const std::vector<Signal>& scans,
                            const std::string& sensor_id,
                            const std::string& option);

// Likewise for odometry; InputErrors are of the port `odometry`.
const Signal& ChooseOdometry(const std::vector<Signal>& odometry,
                             const std::string& sensor_id,
                             const std::string& option);

// The odometry that a job takes, and how much of it may be missing.
struct OdometryChoice {
  std::string sensor;
  OPTION_AT("odometry_sensor", sensor,
            "id of the sensor; empty: the only one that measures odometry");
  double max_gap_s = 0.5;  // between two samples
  OPTION_AT("max_odometry_gap_s", max_gap_s, {0.001, 1000},
            "longest time between two samples of the odometry that a motion may span");

  REGISTER_OPTIONS();
};

}  // namespace nightmap
