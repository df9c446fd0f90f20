// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/ceiling_route.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pipeline/base/error.h"

namespace nightmap {

namespace {

constexpr double kStation_m = 0.005;

double HeadingOf(const Eigen::Vector2d& way) { return std::atan2(way.y(), way.x()); }

// Appends stations after the last one.
class StationList {
 public:
  StationList(const Eigen::Vector2d& start, double heading_rad)
      : stations_{{start, heading_rad, 0, false}} {}

  void Straight(const Eigen::Vector2d& end) {
    const CeilingStation from = stations_.back();
    const double length_m = (end - from.position).norm();
    const int count = std::max(1, static_cast<int>(std::ceil(length_m / kStation_m)));
    if (length_m < 1e-9) return;
    for (int i = 1; i <= count; ++i) {
      const double share = static_cast<double>(i) / count;
      stations_.push_back({from.position + share * (end - from.position),
                           from.heading_rad,
                           from.at_m + share * length_m,
                           false});
    }
  }
  void Arc(double radius_m, double turn_rad) {
    const CeilingStation from = stations_.back();
    const double side = turn_rad > 0 ? 1 : -1;
    const double length_m = radius_m * std::abs(turn_rad);
    const int count = std::max(1, static_cast<int>(std::ceil(length_m / kStation_m)));
    const auto normal = [side](double heading_rad) {
      return Eigen::Vector2d(-side * std::sin(heading_rad), side * std::cos(heading_rad));
    };
    const Eigen::Vector2d center = from.position + radius_m * normal(from.heading_rad);
    for (int i = 1; i <= count; ++i) {
      const double share = static_cast<double>(i) / count;
      const double heading_rad = from.heading_rad + share * turn_rad;
      stations_.push_back({center - radius_m * normal(heading_rad),
                           heading_rad,
                           from.at_m + share * length_m,
                           true});
    }
  }
  std::vector<CeilingStation> Take() { return std::move(stations_); }

 private:
  std::vector<CeilingStation> stations_;
};

}  // namespace

double ShorterTurn_rad(double from_rad, double to_rad) {
  const double turn_rad = std::remainder(to_rad - from_rad, 2 * std::numbers::pi);
  return turn_rad < -std::numbers::pi + 1e-9 ? std::numbers::pi : turn_rad;
}

std::vector<CeilingStation> RoundCorners(const CeilingLeg& leg, double radius_m) {
  if (leg.size() < 2) throw UsageError("a leg of {} points leads nowhere", leg.size());
  StationList list(leg[0], HeadingOf(leg[1] - leg[0]));
  for (std::size_t i = 1; i + 1 < leg.size(); ++i) {
    const Eigen::Vector2d in = leg[i] - leg[i - 1];
    const Eigen::Vector2d out = leg[i + 1] - leg[i];
    const double turn_rad = ShorterTurn_rad(HeadingOf(in), HeadingOf(out));
    const double tangent = std::tan(std::abs(turn_rad) / 2);
    const double cut_m = std::min({radius_m * tangent, in.norm() / 2, out.norm() / 2});
    list.Straight(leg[i] - cut_m * in.normalized());
    if (std::abs(turn_rad) > 1e-9) list.Arc(cut_m / tangent, turn_rad);
  }
  list.Straight(leg.back());
  return list.Take();
}

}  // namespace nightmap
