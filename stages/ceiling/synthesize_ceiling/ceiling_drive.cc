// SPDX-License-Identifier: Apache-2.0
// Times of the robot on its route: speed, acceleration and turns on the spot.
#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/base/error.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_route.h"

namespace nightmap {

namespace {

constexpr double kAccelerationMPerS2 = 0.5;  // by which the robot gains and loses speed
constexpr double kCornerRadius_m = 0.4;      // of the arcs at corners
constexpr double kStandstill_s = 1;          // before the robot begins to drive
constexpr double kDriveRate_hz = 200;
constexpr double kTurnAcceleration_rad_per_s2 = 2;

// Times at which a motion that starts and ends at rest is at each place. `limits` are the highest
// rates between neighbours.
std::vector<double> TimesOf(const std::vector<double>& places,
                            const std::vector<double>& limits,
                            double acceleration) {
  std::vector<double> rates(places.size(), 0);
  for (std::size_t i = 1; i + 1 < places.size(); ++i) {
    const double reachable =
        std::sqrt(rates[i - 1] * rates[i - 1] + 2 * acceleration * (places[i] - places[i - 1]));
    rates[i] = std::min({reachable, limits[i - 1], limits[i]});
  }
  for (std::size_t i = places.size() - 1; i-- > 1;) {
    const double reachable =
        std::sqrt(rates[i + 1] * rates[i + 1] + 2 * acceleration * (places[i + 1] - places[i]));
    rates[i] = std::min(rates[i], reachable);
  }
  std::vector<double> times_s(places.size(), 0);
  for (std::size_t i = 1; i < places.size(); ++i) {
    times_s[i] = times_s[i - 1] + 2 * (places[i] - places[i - 1]) / (rates[i - 1] + rates[i]);
  }
  return times_s;
}

// Stations with their times, and samples of them at kDriveRate_hz.
class DriveRecorder {
 public:
  explicit DriveRecorder(const CeilingRouteOptions& options) : options_(options) {}

  void Stand(const CeilingStation& at) {
    stations_ = {at, at};
    times_s_ = {0, kStandstill_s};
  }
  const CeilingStation& Last() const { return stations_.back(); }

  void Turn(double turn_rad) {
    const CeilingStation from = stations_.back();
    const int count = std::max(2, static_cast<int>(std::ceil(std::abs(turn_rad) / 0.005)));
    std::vector<double> angles_rad;
    std::vector<CeilingStation> stations;
    for (int i = 0; i <= count; ++i) {
      const double share = static_cast<double>(i) / count;
      angles_rad.push_back(share * std::abs(turn_rad));
      stations.push_back({from.position, from.heading_rad + share * turn_rad, 0, false});
    }
    const std::vector<double> limits(angles_rad.size(), options_.turn_rate_rad_per_s);
    Append(stations, TimesOf(angles_rad, limits, kTurnAcceleration_rad_per_s2));
  }
  void Drive(std::vector<CeilingStation> stations) {
    const double unwrap_rad = Last().heading_rad - stations.front().heading_rad;
    const double corner_speed_m_per_s = options_.turn_rate_rad_per_s * kCornerRadius_m;
    std::vector<double> places_m;
    std::vector<double> limits;
    for (std::size_t i = 0; i < stations.size(); ++i) {
      stations[i].heading_rad += unwrap_rad;
      places_m.push_back(stations[i].at_m);
      const bool is_corner =
          stations[i].is_corner || (i + 1 < stations.size() && stations[i + 1].is_corner);
      limits.push_back(is_corner ? std::min(options_.speed_m_per_s, corner_speed_m_per_s)
                                 : options_.speed_m_per_s);
    }
    Append(stations, TimesOf(places_m, limits, kAccelerationMPerS2));
  }

  RobotDrive Recorded() const {
    std::vector<RoutePoint> points;
    std::size_t after = 1;
    const auto num_points = static_cast<std::size_t>(times_s_.back() * kDriveRate_hz) + 1;
    for (std::size_t i = 0; i < num_points; ++i) {
      const double time_s = static_cast<double>(i) / kDriveRate_hz;
      while (after + 1 < times_s_.size() && times_s_[after] < time_s) ++after;
      const CeilingStation& a = stations_[after - 1];
      const CeilingStation& b = stations_[after];
      const double span_s = times_s_[after] - times_s_[after - 1];
      const double t =
          span_s > 0 ? std::clamp((time_s - times_s_[after - 1]) / span_s, 0.0, 1.0) : 1;
      points.push_back({a.position + t * (b.position - a.position),
                        a.heading_rad + t * (b.heading_rad - a.heading_rad),
                        0});
    }
    return {points, kDriveRate_hz};
  }

 private:
  void Append(const std::vector<CeilingStation>& stations, const std::vector<double>& times_s) {
    const double start_s = times_s_.back();
    for (std::size_t i = 1; i < stations.size(); ++i) {
      stations_.push_back(stations[i]);
      times_s_.push_back(start_s + times_s[i]);
    }
  }

  CeilingRouteOptions options_;
  std::vector<CeilingStation> stations_;
  std::vector<double> times_s_;
};

}  // namespace

RobotDrive DriveCeilingLegs(const std::vector<CeilingLeg>& legs,
                            const CeilingRouteOptions& options) {
  if (legs.empty()) throw UsageError("a route without legs leads nowhere");
  DriveRecorder recorder(options);
  for (std::size_t i = 0; i < legs.size(); ++i) {
    std::vector<CeilingStation> stations = RoundCorners(legs[i], kCornerRadius_m);
    if (i == 0) {
      recorder.Stand(stations.front());
    } else {
      const double turn_rad =
          ShorterTurn_rad(recorder.Last().heading_rad, stations.front().heading_rad);
      if (std::abs(turn_rad) > 1e-9) recorder.Turn(turn_rad);
    }
    recorder.Drive(std::move(stations));
  }
  return recorder.Recorded();
}

RobotDrive CutDrive(const RobotDrive& drive, double duration_s) {
  if (duration_s >= drive.Duration_s()) return drive;
  std::vector<RoutePoint> points;
  const auto num_points = static_cast<std::size_t>(duration_s * kDriveRate_hz + 1e-6) + 1;
  for (std::size_t i = 0; i < num_points; ++i) {
    points.push_back(drive.At(static_cast<double>(i) / kDriveRate_hz));
  }
  return {points, kDriveRate_hz};
}

}  // namespace nightmap
