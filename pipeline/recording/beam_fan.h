// SPDX-License-Identifier: Apache-2.0
// Beams of a scan as directions, evenly spaced.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "pipeline/recording/signals_io.h"

namespace nightmap {

struct BeamFan {
  double start_rad = 0;
  double step_rad = 0;
  std::size_t count = 0;

  double Angle_rad(std::size_t idx) const {
    return start_rad + step_rad * static_cast<double>(idx);
  }
  // The beam that points about there; none outside of them.
  std::optional<std::size_t> BeamAt(double angle_rad) const;
  double Step_deg() const;  // above 0; 1 of a single beam
  bool IsCircle() const;    // whether the last beam is a neighbour of the first
};

BeamFan FanOf(const SignalSample& scan);
// The fan is that of a scan that has as many beams as most, of one or more scans.
BeamFan UsualFan(const std::vector<SignalSample>& scans);

// From and to of the sectors that hold the beams that are inside, as blind_deg of a [[sensor]],
// with half a beam or more on each side. Beams up to 2 deg apart share a sector. Pure.
std::vector<int> SectorsOf_deg(const BeamFan& fan, const std::vector<bool>& is_inside);

}  // namespace nightmap
