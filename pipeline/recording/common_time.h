// SPDX-License-Identifier: Apache-2.0
// Whether odometry and scans are of one time.
#pragma once

#include <string>
#include <vector>

#include "pipeline/recording/signals_io.h"
#include "pipeline/recording/site_config.h"

namespace nightmap {

// Texts on odometry that covers less than half of a scanner's scans, one each. Throws
// DataError, which names both times and the offset between their starts, when it covers no moment
// of any scanner: then it has another clock. Odometry that is the truth of the site is not asked,
// nor is that of a site with cameras, which may be of their time. `signals` are one per sensor.
std::vector<std::string> DemandCommonTime(const SiteConfig& site,
                                          const std::vector<Signal>& signals);

}  // namespace nightmap
