// SPDX-License-Identifier: Apache-2.0
// Motions and counts of wheels, summed up to poses.
#pragma once

#include <vector>

#include "pipeline/recording/signals_io.h"
#include "pipeline/recording/site_config.h"

namespace nightmap {

// Makes poses of what the samples measure, if it is not that. The first pose of ticks is the
// origin. Counters that both jump to 0 were switched on again: the pose is the origin again, which
// IsPossibleStep of wheel_motion.h takes for a gap.
void SumUpOdometry(const SensorConfig& sensor, std::vector<SignalSample>* samples);

}  // namespace nightmap
