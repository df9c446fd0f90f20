// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/choose_signal.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "pipeline/base/input_error.h"

namespace nightmap {
namespace {

// How messages speak of a kind.
struct WordsOfKind {
  std::string port;
  std::string kind;      // of a [[sensor]]
  std::string measures;  // "no sensor of the site ..."
  std::string measure;   // "the sensors that ..."
  std::string sample;    // "sensor 'x' has no ..."
};

const Signal& Choose(const std::vector<Signal>& signals,
                     const std::string& sensor_id,
                     const std::string& option,
                     const WordsOfKind& words) {
  if (signals.empty()) {
    throw InputError({{words.port}},
                     InputError::Remedy::kInText,
                     "no sensor of the site {}; add a [[sensor]] of kind \"{}\" and its "
                     "[[signal]] to the site config, or map without the profile",
                     words.measures,
                     words.kind);
  }
  const auto found = sensor_id.empty() && signals.size() == 1
                         ? signals.begin()
                         : std::ranges::find(signals, sensor_id, &Signal::sensor_id);
  if (found != signals.end()) {
    if (!found->samples.empty()) return *found;
    throw InputError({{words.port}},
                     InputError::Remedy::kInText,
                     "sensor '{}' has no {}; add its [[signal]] to the site config",
                     found->sensor_id,
                     words.sample);
  }
  std::vector<std::string> ids;
  for (const Signal& signal : signals) ids.push_back(signal.sensor_id);
  throw UsageError("{} is '{}': choose one of the sensors that {}: {}",
                   option,
                   sensor_id,
                   words.measure,
                   fmt::join(ids, ", "));
}

}  // namespace

const Signal& ChooseScanner(const std::vector<Signal>& scans,
                            const std::string& sensor_id,
                            const std::string& option) {
  return Choose(scans, sensor_id, option, {"scans", "scan", "scans", "scan", "scan"});
}

const Signal& ChooseOdometry(const std::vector<Signal>& odometry,
                             const std::string& sensor_id,
                             const std::string& option) {
  return Choose(odometry,
                sensor_id,
                option,
                {"odometry", "odometry", "measures odometry", "measure odometry", "sample"});
}

}  // namespace nightmap
