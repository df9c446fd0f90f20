// SPDX-License-Identifier: Apache-2.0
// Where the beams of a scan point.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "pipeline/recording/site_config.h"

namespace nightmap {

// Angles that a line of a log states.
struct LineAngles {
  double start_rad = 0;
  double field_of_view_rad = 0;
  double step_rad = 0;  // 0: the beams share the field of view
};

// Angle of the first beam and step from beam to beam, in rad, counter-clockwise from the sensor's
// x. The site config's statement holds, then the line's. Without either, the beams lie
// symmetrically about x, from the start on, which is -90 deg unless the config states another: a
// full circle of n beams has steps of 360/n; a part of F degrees has steps of F/n, or F/(n - 1)
// where that is a degree or a whole part of one, because the last beam then mirrors the first. This
// is CARMEN's rule for 180, 181, 360 and 361 beams.
//
// No scanner sees more than a circle. Beams whose stated steps lead a little farther share the
// circle; those whose steps lead much farther are a DataError. Pure.
Eigen::Vector2d BeamAngles_rad(const SensorConfig& sensor,
                               std::size_t num_beams,
                               const std::optional<LineAngles>& of_line = {});

// The scans of a scanner that turns unevenly each have another number of beams, and all span the
// circle, whatever step is stated for them. Such a scanner has more than a few scans with more
// beams than fit in a circle by the stated step; a scan that lacks a beam does not make one.
// Gives its scans the steps by which their beams share the circle. Pure.
void ShareCircle(const SensorConfig& sensor, std::vector<SignalSample>* scans);

}  // namespace nightmap
