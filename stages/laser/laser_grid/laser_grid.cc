// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/laser_grid/laser_grid.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/base/input_error.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/choose_signal.h"

namespace nightmap {
namespace {

// Why a scan at this time has no pose.
const char* Cause(const std::vector<StampedPose>& trajectory, std::int64_t time_ns) {
  if (trajectory.empty() || time_ns < trajectory.front().time_ns) {
    return "is before the trajectory";
  }
  if (time_ns > trajectory.back().time_ns) return "is after the trajectory";
  return "the poses around it are more than max_gap_s apart";
}

// The sensor's pose when a scan that takes a while is over; none at the end of the trajectory.
std::optional<Rigid3> PoseAtEnd(const Signal& signal,
                                const SignalSample& scan,
                                const std::vector<StampedPose>& trajectory,
                                std::int64_t max_gap_ns) {
  if (signal.scan_duration_s <= 0) return std::nullopt;
  const std::int64_t end_ns = scan.time_ns + std::llround(1e9 * signal.scan_duration_s);
  const auto map_from_robot = PoseAt(trajectory, end_ns, max_gap_ns);
  if (!map_from_robot) return std::nullopt;
  return *map_from_robot * signal.robot_from_sensor;
}

std::vector<PlacedScan> PlaceScans(const LaserGridOptions& options,
                                   const Signal& signal,
                                   const std::vector<StampedPose>& trajectory,
                                   std::vector<std::string>* skipped) {
  const auto max_gap_ns = static_cast<std::int64_t>(std::llround(1e9 * options.max_gap_s));
  std::vector<PlacedScan> placed;
  for (const SignalSample& scan : signal.samples) {
    const auto map_from_robot = PoseAt(trajectory, scan.time_ns, max_gap_ns);
    if (!map_from_robot) {
      skipped->push_back(fmt::format(
          "scan at {}: {}", TimeToString(scan.time_ns), Cause(trajectory, scan.time_ns)));
      continue;
    }
    placed.push_back({*map_from_robot * signal.robot_from_sensor,
                      scan.value[0],
                      scan.value[1],
                      scan.value[2],
                      scan.ranges_m,
                      PoseAtEnd(signal, scan, trajectory, max_gap_ns)});
  }
  return placed;
}

std::string Span(std::int64_t first_ns, std::int64_t last_ns) {
  return fmt::format("{} to {}", TimeToString(first_ns), TimeToString(last_ns));
}

void CheckPlaced(const Signal& signal,
                 const std::vector<StampedPose>& trajectory,
                 const std::vector<PlacedScan>& placed) {
  if (!placed.empty()) return;
  if (signal.samples.empty() || trajectory.empty()) {
    throw InputError({{"scans"}, {"trajectory"}},
                     InputError::Remedy::kInText,
                     "sensor '{}' has {} scans and the trajectory {} poses; check [[signal]] in "
                     "the site config and the job that made the trajectory",
                     signal.sensor_id,
                     signal.samples.size(),
                     trajectory.size());
  }
  throw InputError({{"scans"}, {"trajectory"}},
                   InputError::Remedy::kInText,
                   "no scan of sensor '{}' ({} s) has a pose of the trajectory ({} s); correct "
                   "time_offset_s of its [[signal]] in the site config (`make inspect` shows the "
                   "times), or raise laser_grid.max_gap_s",
                   signal.sensor_id,
                   Span(signal.samples.front().time_ns, signal.samples.back().time_ns),
                   Span(trajectory.front().time_ns, trajectory.back().time_ns));
}

}  // namespace

LaserGridResult RunLaserGrid(const LaserGridOptions& options, const LaserGridInput& input) {
  const Signal& signal = ChooseScanner(input.scans, options.sensor, "laser_grid.sensor");
  LaserGridResult result;
  result.sensor_id = signal.sensor_id;
  result.num_scans = signal.samples.size();
  const auto placed = PlaceScans(options, signal, input.trajectory, &result.skipped);
  CheckPlaced(signal, input.trajectory, placed);
  result.map = GridOfScans(options.grid, placed);
  return result;
}

nlohmann::json DescribeLaserGrid(const LaserGridResult& result) {
  const OccupancyGrid& grid = result.map.grid;
  const auto count = [&](CellValue value) { return std::ranges::count(grid.cells, value); };
  const double cell_m2 = grid.resolution_m * grid.resolution_m;
  return {{"sensor", result.sensor_id},
          {"num_scans", result.num_scans},
          {"num_used_scans", result.num_scans - result.skipped.size()},
          {"num_beams", result.map.num_beams},
          {"num_hits", result.map.num_hits},
          {"width_cells", grid.width},
          {"height_cells", grid.height},
          {"resolution_m", grid.resolution_m},
          {"num_free_cells", count(kFreeCell)},
          {"num_occupied_cells", count(kOccupiedCell)},
          {"num_unknown_cells", count(kUnknownCell)},
          {"free_area_m2", cell_m2 * static_cast<double>(count(kFreeCell))}};
}

}  // namespace nightmap
