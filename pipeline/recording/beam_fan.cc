// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/beam_fan.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pipeline/base/median.h"

namespace nightmap {
namespace {

constexpr double kDegPerRad = 180 / std::numbers::pi;
constexpr double kTurn_deg = 360;
constexpr double kHole_deg = 2;  // at most, between beams of one sector
constexpr double kRounded_deg = 1e-6;

}  // namespace

std::optional<std::size_t> BeamFan::BeamAt(double angle_rad) const {
  const double idx = std::round((angle_rad - start_rad) / step_rad);
  if (!(idx >= 0 && idx < static_cast<double>(count))) return std::nullopt;
  return static_cast<std::size_t>(idx);
}

double BeamFan::Step_deg() const { return step_rad == 0 ? 1 : kDegPerRad * std::abs(step_rad); }

bool BeamFan::IsCircle() const {
  return (static_cast<double>(count) + 0.5) * Step_deg() > kTurn_deg;
}

BeamFan FanOf(const SignalSample& scan) {
  return {scan.value[0], scan.value[1], scan.ranges_m.size()};
}

BeamFan UsualFan(const std::vector<SignalSample>& scans) {
  std::vector<std::size_t> counts;
  for (const SignalSample& scan : scans) counts.push_back(scan.ranges_m.size());
  return FanOf(*std::ranges::find(
      scans, Median(counts), [](const SignalSample& scan) { return scan.ranges_m.size(); }));
}

std::vector<int> SectorsOf_deg(const BeamFan& fan, const std::vector<bool>& is_inside) {
  const double step_deg = fan.Step_deg();
  std::vector<double> angles_deg;
  for (std::size_t i = 0; i < fan.count; ++i) {
    if (is_inside[i]) angles_deg.push_back(kDegPerRad * fan.Angle_rad(i));
  }
  std::ranges::sort(angles_deg);
  std::vector<std::pair<double, double>> sectors_deg;
  for (const double angle_deg : angles_deg) {
    if (sectors_deg.empty() || angle_deg - sectors_deg.back().second > step_deg + kHole_deg) {
      sectors_deg.emplace_back(angle_deg, angle_deg);
    }
    sectors_deg.back().second = angle_deg;
  }
  if (fan.IsCircle() && sectors_deg.size() > 1 &&
      sectors_deg.front().first + kTurn_deg - sectors_deg.back().second <= step_deg + kHole_deg) {
    sectors_deg.back().second = sectors_deg.front().second + kTurn_deg;
    sectors_deg.erase(sectors_deg.begin());
  }
  std::vector<int> result;
  for (const auto& [first_deg, last_deg] : sectors_deg) {
    const double from_deg = std::floor(first_deg - step_deg / 2 + kRounded_deg);
    const double to_deg = std::ceil(last_deg + step_deg / 2 - kRounded_deg);
    const double turn_deg = to_deg > kTurn_deg ? kTurn_deg : 0;
    result.push_back(static_cast<int>(from_deg - turn_deg));
    result.push_back(static_cast<int>(to_deg - turn_deg));
  }
  return result;
}

}  // namespace nightmap
