// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/query_cameras.h"

#include <algorithm>

#include "pipeline/base/input_error.h"

namespace nightmap {

std::vector<RgbdCamera> WithCalibration(std::vector<RgbdCamera> query_cameras,
                                        const std::vector<RgbdCamera>& configured,
                                        const std::vector<RgbdCamera>& calibrated) {
  if (configured.size() != calibrated.size()) {
    throw InputError({{"configured"}, {"calibrated"}},
                     "{} cameras configured, {} calibrated",
                     configured.size(),
                     calibrated.size());
  }
  for (RgbdCamera& camera : query_cameras) {
    if (!camera.IsCalibrated()) continue;
    const auto same = std::ranges::find_if(
        configured, [&](const RgbdCamera& other) { return other.color == camera.color; });
    if (same == configured.end()) continue;
    camera.color = calibrated[static_cast<std::size_t>(same - configured.begin())].color;
  }
  return query_cameras;
}

}  // namespace nightmap
