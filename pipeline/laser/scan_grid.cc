// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/scan_grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "pipeline/base/input_error.h"
#include "pipeline/geometry/log_odds.h"
#include "pipeline/laser/thin_walls.h"
#include "pipeline/plan/cell_walk.h"

namespace nightmap {
namespace {

// Probability that a cell is occupied when one scan passed it.
constexpr double kMissProbability = 0.4;
// Limit of ln(p / (1 - p)) of a cell; with less the last scans count more.
constexpr double kMaxLogOdds = 14;
constexpr double kMaxIndex = 1e9;  // cells to the map's origin, where a double resolves 1e-7 cells
constexpr double kMaxCells = 4e8;  // a square kilometre at 5 cm
constexpr double kRadPerDegree = std::numbers::pi / 180;
constexpr double kMaxBeamsOfGroup = 1000;

// A beam that ends in a hit, or clears the cells up to its end.
struct Beam {
  Eigen::Vector2d start_in_map;
  Eigen::Vector2d end_in_map;
  bool is_hit = false;
};

// How far the beam clears cells; 0 when its range says nothing.
double Length_m(const ScanGridOptions& options, const PlacedScan& scan, double range_m) {
  if (!(range_m >= options.min_range_m)) return 0;  // NaN too
  return range_m < scan.limit_m ? std::min(range_m, options.max_range_m) : options.clear_range_m;
}

struct PlanarPose {
  Eigen::Vector2d sensor_in_map;
  Eigen::Matrix2d rotation;
};

PlanarPose InPlane(const Rigid3& map_from_sensor) {
  return {map_from_sensor.translation.head<2>(),
          map_from_sensor.rotation.toRotationMatrix().topLeftCorner<2, 2>()};
}

// Beams that lie within a degree, at least one.
std::size_t BeamsPerGroup(const PlacedScan& scan) {
  const double per_degree = kRadPerDegree / std::abs(scan.step_angle_rad);
  return per_degree < 2 ? 1 : static_cast<std::size_t>(std::min(per_degree, kMaxBeamsOfGroup));
}

// The pose in the middle of the beams from `first` on, while the scanner moves.
Rigid3 PoseOfGroup(const PlacedScan& scan, std::size_t first, std::size_t num_of_group) {
  const std::size_t last = std::min(first + num_of_group, scan.ranges_m.size()) - 1;
  const double share =
      0.5 * static_cast<double>(first + last) / static_cast<double>(scan.ranges_m.size());
  const Rigid3 &start = scan.map_from_sensor, &end = *scan.map_from_sensor_at_end;
  return {start.rotation.slerp(share, end.rotation),
          start.translation + share * (end.translation - start.translation)};
}

// Calls visit(beam) for each beam of the scan that says something, in their order.
template <typename Visit>
void ForEachBeam(const ScanGridOptions& options, const PlacedScan& scan, const Visit& visit) {
  PlanarPose pose = InPlane(scan.map_from_sensor);
  const std::size_t num_of_group = BeamsPerGroup(scan);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    if (scan.map_from_sensor_at_end && i % num_of_group == 0) {
      pose = InPlane(PoseOfGroup(scan, i, num_of_group));
    }
    const double range_m = scan.ranges_m[i];
    const double length_m = Length_m(options, scan, range_m);
    if (length_m <= 0) continue;
    const double angle_rad = scan.first_angle_rad + static_cast<double>(i) * scan.step_angle_rad;
    const Eigen::Vector2d direction(std::cos(angle_rad), std::sin(angle_rad));
    visit(Beam{pose.sensor_in_map,
               pose.sensor_in_map + length_m * (pose.rotation * direction),
               range_m < scan.limit_m && range_m < options.max_range_m});
  }
}

// Sums the log-odds of the cells of a grid.
class Filler {
 public:
  Filler(const ScanGridOptions& options, OccupancyGrid& grid)
      : options_(options),
        grid_(grid),
        hit_(LogOdds(options.hit_probability)),
        miss_(LogOdds(kMissProbability)),
        max_(static_cast<float>(kMaxLogOdds)),
        log_odds_(grid.cells.size()),
        num_hits_(grid.cells.size()),
        marks_(grid.cells.size()) {}

  void Add(const PlacedScan& scan) {
    hit_mark_ += 2;
    // Hits come first: beams that graze a wall pass through cells that their neighbours hit.
    ForEachBeam(options_, scan, [&](const Beam& beam) {
      if (beam.is_hit) AddHit(grid_.CellOf(beam.end_in_map));
    });
    ForEachBeam(options_, scan, [&](const Beam& beam) {
      WalkCells(grid_.ToCells(beam.start_in_map),
                grid_.ToCells(beam.end_in_map),
                [&](const Eigen::Vector2i& cell) { Update(cell, miss_, hit_mark_ + 1); });
    });
  }

  // Decides the cells.
  void Finish() {
    for (std::size_t i = 0; i < grid_.cells.size(); ++i) {
      if (marks_[i] == 0) continue;
      grid_.cells[i] = log_odds_[i] > 0 ? kOccupiedCell : kFreeCell;
    }
    if (options_.thin_walls) ThinWalls(num_hits_, &grid_);
  }

 private:
  void AddHit(const Eigen::Vector2i& cell) {
    ++num_hits_[grid_.Index(cell.x(), cell.y())];
    Update(cell, hit_, hit_mark_);
  }

  // Changes a cell that this scan did not change yet.
  void Update(const Eigen::Vector2i& cell, float change, std::uint32_t mark) {
    const std::size_t i = grid_.Index(cell.x(), cell.y());
    if (marks_[i] >= hit_mark_) return;
    marks_[i] = mark;
    log_odds_[i] = std::clamp(log_odds_[i] + change, -max_, max_);
  }

  const ScanGridOptions& options_;
  OccupancyGrid& grid_;
  float hit_, miss_, max_;
  std::vector<float> log_odds_;
  std::vector<std::uint32_t> num_hits_;
  std::vector<std::uint32_t> marks_;  // of the last scan that changed the cell; 0: none did
  std::uint32_t hit_mark_ = 0;  // of this scan: this for cells that it hits, one more for others
};

// A grid of unknown cells around the box, at least one cell wider on each side so that rounding
// keeps its border inside. Cells end at multiples of the resolution, so that more scans do not
// shift them.
OccupancyGrid UnknownGrid(double resolution_m, double margin_m, const Eigen::AlignedBox2d& box) {
  const double margin = std::ceil(margin_m / resolution_m) + 1;
  const Eigen::Array2d first = (box.min() / resolution_m).array().floor() - margin;
  const Eigen::Array2d size = (box.max() / resolution_m).array().floor() + margin - first + 1;
  if (!(size.prod() <= kMaxCells && first.abs().maxCoeff() < kMaxIndex)) {
    throw InputError(
        {{"scans"}, {"trajectory"}},
        InputError::Remedy::kInText,
        "the scans reach from ({:.0f}, {:.0f}) to ({:.0f}, {:.0f}) m, too far for cells of {} m: "
        "check the trajectory, or raise resolution_m",
        box.min().x(),
        box.min().y(),
        box.max().x(),
        box.max().y(),
        resolution_m);
  }
  OccupancyGrid grid;
  grid.width = static_cast<int>(size.x());
  grid.height = static_cast<int>(size.y());
  grid.resolution_m = resolution_m;
  grid.origin_in_map = resolution_m * first.matrix();
  grid.cells.assign(static_cast<std::size_t>(size.prod()), kUnknownCell);
  return grid;
}

}  // namespace

ScanGrid GridOfScans(const ScanGridOptions& options, std::span<const PlacedScan> scans) {
  ScanGrid result;
  Eigen::AlignedBox2d box;
  for (const PlacedScan& scan : scans) {
    box.extend(Eigen::Vector2d(scan.map_from_sensor.translation.head<2>()));
    result.num_beams += scan.ranges_m.size();
    ForEachBeam(options, scan, [&](const Beam& beam) {
      box.extend(beam.start_in_map);
      box.extend(beam.end_in_map);
      result.num_hits += beam.is_hit ? 1 : 0;
    });
  }
  if (result.num_hits == 0) {
    throw InputError(
        {{"scans"}},
        InputError::Remedy::kInText,
        "no beam of {} scans hit anything between min_range_m = {} and max_range_m = {}: check "
        "both, and max_range_m of the [[sensor]] in the site config",
        scans.size(),
        options.min_range_m,
        options.max_range_m);
  }
  result.grid = UnknownGrid(options.resolution_m, options.margin_m, box);
  Filler filler(options, result.grid);
  for (const PlacedScan& scan : scans) filler.Add(scan);
  filler.Finish();
  return result;
}

}  // namespace nightmap
