// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/hold_out_scans/hold_out_scans.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pipeline/base/random.h"
#include "pipeline/geometry/plane_grid.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/choose_signal.h"
#include "pipeline/recording/scan_points.h"

namespace nightmap {
namespace {

constexpr double kQueryDistance_m = 0.5;  // path between two queries

struct PlacedSample {
  const SignalSample* scan = nullptr;
  StampedPose pose;
  double path_m = 0;  // of the robot until then
};

std::vector<PlacedSample> PlaceSamples(const Signal& signal,
                                       const std::vector<StampedPose>& trajectory) {
  std::vector<PlacedSample> placed;
  for (const SignalSample& scan : signal.samples) {
    const int row = FindPose(trajectory, scan.time_ns);
    if (row < 0) continue;
    PlacedSample sample{&scan, trajectory[static_cast<std::size_t>(row)], 0};
    if (!placed.empty()) {
      const PlacedSample& last = placed.back();
      sample.path_m =
          last.path_m + (sample.pose.pose.translation - last.pose.pose.translation).norm();
    }
    placed.push_back(sample);
  }
  return placed;
}

bool IsHeldOut(const HoldOutScansOptions& options, double path_m) {
  return static_cast<long>(path_m / options.block_m) % options.every == options.every - 1;
}

// The places of the scans that stay.
class MappedPlaces {
 public:
  MappedPlaces(std::vector<Eigen::Vector3d> points, double near_m)
      : points_(std::move(points)), near_m_(near_m), grid_(FromAbove(points_), near_m) {}

  bool HasNear(const Eigen::Vector3d& point) const {
    return std::ranges::any_of(grid_.Near(point.head<2>(), near_m_), [&](std::size_t i) {
      return (points_[i] - point).norm() <= near_m_;
    });
  }

 private:
  static std::vector<Eigen::Vector2d> FromAbove(const std::vector<Eigen::Vector3d>& points) {
    std::vector<Eigen::Vector2d> places;
    for (const Eigen::Vector3d& point : points) places.emplace_back(point.head<2>());
    return places;
  }

  std::vector<Eigen::Vector3d> points_;
  double near_m_;
  PlaneGrid grid_;
};

std::optional<RoughPosition> DrawPosition(const HoldOutScansOptions& options,
                                          const Rigid3& map_from_robot,
                                          std::size_t query_idx) {
  if (options.rough_radius_m <= 0) return std::nullopt;
  Random random(static_cast<std::uint64_t>(options.seed), query_idx);
  const double angle_rad = random.Uniform(0, 2 * std::numbers::pi);
  const double distance_m = options.rough_radius_m * std::sqrt(random.Uniform());
  const Eigen::Vector2d offset(std::cos(angle_rad), std::sin(angle_rad));
  return RoughPosition{map_from_robot.translation.head<2>() + distance_m * offset,
                       options.rough_radius_m};
}

ScanQuery MakeQuery(const HoldOutScansOptions& options,
                    const Signal& signal,
                    const PlacedSample& sample,
                    std::size_t query_idx) {
  const SignalSample& scan = *sample.scan;
  ScanQuery query{TimeToString(scan.time_ns), scan.time_ns, {}, {}};
  const ScannerFromAbove scanner = SeenFromAbove(signal.robot_from_sensor);
  const double sense = scanner.is_upside_down ? -1 : 1;
  query.scans.push_back({scanner.robot_from_laser,
                         sense * scan.value[0],
                         sense * scan.value[1],
                         scan.value[2],
                         scan.ranges_m});
  query.rough_position = DrawPosition(options, sample.pose.pose, query_idx);
  return query;
}

// The scanner without the scans at these poses, which are in order of time.
Signal Without(const Signal& signal, const std::vector<PlacedSample>& held_out) {
  Signal rest = signal;
  std::erase_if(rest.samples, [&](const SignalSample& scan) {
    return std::ranges::binary_search(
        held_out, scan.time_ns, {}, [](const auto& sample) { return sample.scan->time_ns; });
  });
  return rest;
}

// Leaves max_queries of the queries, evenly from all of them.
void Thin(int max_queries, HeldOutScans* result) {
  const std::size_t count = result->queries.size();
  const auto most = static_cast<std::size_t>(max_queries);
  if (count <= most) return;
  for (std::size_t i = 0; i < most; ++i) {
    const std::size_t from = i * count / most;
    if (from == i) continue;
    result->queries[i] = std::move(result->queries[from]);
    result->truth[i] = result->truth[from];
  }
  result->queries.resize(most);
  result->truth.resize(most);
  result->num_left_out = count - most;
}

}  // namespace

HeldOutScans RunHoldOutScans(const HoldOutScansOptions& options, const HoldOutScansInput& input) {
  const Signal& signal = ChooseScanner(input.scans, options.sensor, "hold_out_scans.sensor");
  std::vector<PlacedSample> held_out;
  std::vector<Eigen::Vector3d> mapped_points;
  for (const PlacedSample& sample : PlaceSamples(signal, input.trajectory)) {
    if (IsHeldOut(options, sample.path_m)) {
      held_out.push_back(sample);
    } else {
      mapped_points.push_back(sample.pose.pose.translation);
    }
  }
  const MappedPlaces mapped(std::move(mapped_points), options.near_m);
  HeldOutScans result{{Without(signal, held_out)}, {}, {}, held_out.size(), 0, 0};
  double next_m = 0;
  for (const PlacedSample& sample : held_out) {
    if (!mapped.HasNear(sample.pose.pose.translation)) {
      ++result.num_far;
      continue;
    }
    if (sample.path_m < next_m) continue;
    next_m = sample.path_m + kQueryDistance_m;
    result.queries.push_back(MakeQuery(options, signal, sample, result.queries.size()));
    result.truth.push_back(sample.pose);
  }
  Thin(options.max_queries, &result);
  return result;
}

}  // namespace nightmap
