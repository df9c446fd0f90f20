// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/choose_signal.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "pipeline/base/input_error.h"

namespace nightmap {

const Signal& ChooseScanner(const std::vector<Signal>& scans,
                            const std::string& sensor_id,
                            const std::string& option) {
  if (scans.empty()) {
    throw InputError({{"scans"}},
                     InputError::Remedy::kInText,
                     "no sensor of the site scans; add a [[sensor]] of kind \"scan\" and its "
                     "[[signal]] to the site config, or map without the profile");
  }
  const auto found = sensor_id.empty() && scans.size() == 1
                         ? scans.begin()
                         : std::ranges::find(scans, sensor_id, &Signal::sensor_id);
  if (found != scans.end()) {
    if (!found->samples.empty()) return *found;
    throw InputError({{"scans"}},
                     InputError::Remedy::kInText,
                     "sensor '{}' has no scan; add its [[signal]] to the site config",
                     found->sensor_id);
  }
  std::vector<std::string> ids;
  for (const Signal& signal : scans) ids.push_back(signal.sensor_id);
  throw UsageError("{} is '{}': choose one of the sensors that scan: {}",
                   option,
                   sensor_id,
                   fmt::join(ids, ", "));
}

}  // namespace nightmap
