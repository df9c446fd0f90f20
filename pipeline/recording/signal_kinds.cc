// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/signal_kinds.h"

#include <algorithm>
#include <stdexcept>

#include "pipeline/recording/time_unit.h"

namespace nightmap {

const std::vector<SignalKindRow>& SignalKinds() {
  static const std::vector<SignalKindRow> kinds = {
      {.kind = SignalKind::kAcceleration,
       .name = "acceleration",
       .file = "acceleration.h5",
       .values = {{{"ax", "m/s2"}, {"ay", "m/s2"}, {"az", "m/s2"}}},
       .max_step_s = 2,  // slower samples measure no motion
       .max_value = 1e5,
       .a_value = "an acceleration, which is in m/s2,"},
      {.kind = SignalKind::kOdometry,
       .name = "odometry",
       .file = "odometry.h5",
       .values = {{{"x", "m"}, {"y", "m"}, {"heading", "rad"}}},
       .max_step_s = kMaxFrameStep_s,
       .has_line_clock = true},
      {.kind = SignalKind::kScan,
       .name = "scan",
       .file = "scans.h5",
       .values = {{{"start_angle", "rad"}, {"angle_step", "rad"}, {"max_range", "m"}}},
       .max_step_s = kMaxFrameStep_s,
       .has_line_clock = true}};
  return kinds;
}

const SignalKindRow& RowOf(SignalKind kind) {
  const auto found = std::ranges::find(SignalKinds(), kind, &SignalKindRow::kind);
  if (found == SignalKinds().end()) throw std::logic_error("a kind of sensor without a row");
  return *found;
}

std::optional<SignalKind> KindOf(std::string_view name) {
  const auto found = std::ranges::find(SignalKinds(), name, &SignalKindRow::name);
  return found == SignalKinds().end() ? std::nullopt : std::optional(found->kind);
}

}  // namespace nightmap
