// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/scan_angles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kCircle_deg = 360;
constexpr double kRounded = 1.002;            // a step as written, by its exact value
constexpr double kMinShareOverCircle = 0.05;  // of the scans of a scanner that turns unevenly
constexpr double kMostTooLarge = 1.1;  // a step as stated, by that of a scanner that turned slowly

// The step of beams that share a field of view.
double SharedStep_deg(double field_of_view_deg, std::size_t num_beams) {
  const auto count = static_cast<double>(num_beams);
  if (field_of_view_deg >= kCircle_deg) return kCircle_deg / count;
  const bool last_mirrors_first =
      num_beams > 1 && std::abs(std::remainder(count - 1, field_of_view_deg)) < 1e-3;
  return field_of_view_deg / (last_mirrors_first ? count - 1 : count);
}

double Span_deg(double step_deg, std::size_t num_beams) {
  return (static_cast<double>(num_beams) - 1) * std::abs(step_deg);
}

bool FitsInCircle(double step_deg, std::size_t num_beams) {
  return Span_deg(step_deg, num_beams) <= kRounded * kCircle_deg;
}

double WithinCircle_rad(double step_rad, std::size_t num_beams) {
  const double step_deg = step_rad / kRadPerDeg;
  if (FitsInCircle(step_deg, num_beams)) return step_rad;
  const auto count = static_cast<double>(num_beams);
  const double size_deg = std::abs(step_deg);
  if (count * size_deg <= kMostTooLarge * kCircle_deg) {
    return kRadPerDeg * std::copysign(kCircle_deg / count, step_deg);
  }
  throw DataError(
      "{} beams {:.4g} deg apart span {:.0f} deg, more than a circle: correct angle_step_deg, or, "
      "where a line holds more than ranges, as intensities, write lines of ranges alone",
      num_beams,
      step_deg,
      Span_deg(step_deg, num_beams));
}

}  // namespace

Eigen::Vector2d BeamAngles_rad(const SensorConfig& sensor,
                               std::size_t num_beams,
                               const std::optional<LineAngles>& of_line) {
  const double stated_deg = sensor.start_angle_deg.value_or(-90);
  const bool is_of_line = of_line && !sensor.start_angle_deg;
  const double start_rad = is_of_line ? of_line->start_rad : kRadPerDeg * stated_deg;
  double step_rad = kRadPerDeg * sensor.angle_step_deg;
  if (step_rad == 0 && of_line) step_rad = of_line->step_rad;
  if (step_rad == 0) {
    const double field_of_view_deg =
        of_line ? of_line->field_of_view_rad / kRadPerDeg : -2 * stated_deg;
    step_rad = kRadPerDeg * SharedStep_deg(field_of_view_deg, num_beams);
  }
  if (step_rad == 0) {
    throw DataError(
        "the line states no angles: write start_angle_deg and angle_step_deg in the [[sensor]]");
  }
  return {start_rad, WithinCircle_rad(step_rad, num_beams)};
}

void ShareCircle(const SensorConfig& sensor, std::vector<SignalSample>* scans) {
  if (sensor.angle_step_deg == 0) return;
  const auto num_over = std::ranges::count_if(*scans, [&](const SignalSample& scan) {
    return !FitsInCircle(sensor.angle_step_deg, scan.ranges_m.size());
  });
  const auto num_scans = static_cast<double>(scans->size());
  if (static_cast<double>(num_over) <= kMinShareOverCircle * num_scans) return;
  for (SignalSample& scan : *scans) {
    const double step_deg = kCircle_deg / static_cast<double>(scan.ranges_m.size());
    scan.value[1] = kRadPerDeg * std::copysign(step_deg, sensor.angle_step_deg);
  }
}

}  // namespace nightmap
