// SPDX-License-Identifier: Apache-2.0
// An occupancy grid from the scans of a 2-D laser scanner whose poses are known: Moravec, Elfes,
// "High resolution maps from wide angle sonar" (ICRA 1985), with log-odds as in Thrun, Burgard,
// Fox, "Probabilistic Robotics" (2005), 9.2.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

// The defaults of hit and miss are those of OctoMap (Hornung et al., 2013): a cell is occupied when
// more than 32 % of the scans that reach it hit it, |miss| / (hit + |miss|) in log-odds. People who
// walk by hit a cell in far fewer. A wall is not hit in all: it fills only a part of its cells, and
// beams along it pass through the rest; poses that are a few centimetres off do the same.
struct ScanGridOptions {
  OPTION(double, resolution_m, 0.05, {0.005, 1}, "edge length of a cell");
  OPTION(double, hit_probability, 0.7, {0.501, 0.99},
         "probability that a cell is occupied when one scan hit it");
  OPTION(double, min_range_m, 0.1, {0.001, 10}, "ignores shorter ranges");
  OPTION(double, max_range_m, 30, {0.5, 1000},
         "a beam that hit something farther away clears the cells up to this range");
  OPTION(double, clear_range_m, 0, {0, 1000},
         "a beam that hit nothing clears the cells up to this range");
  OPTION(bool, thin_walls, true, "draws straight walls one cell wide, where most beams hit them");
  OPTION(double, margin_m, 0.25, {0, 100}, "unknown space around the map");
  REGISTER_OPTIONS();
};

// One scan. Beam i points at first_angle_rad + i * step_angle_rad, counter-clockwise from the
// sensor's x in its plane z = 0.
struct PlacedScan {
  Rigid3 map_from_sensor;
  double first_angle_rad = 0;
  double step_angle_rad = 0;
  double limit_m = 0;               // the scanner reports this or more where it hit nothing
  std::span<const float> ranges_m;  // one for each beam
  // The pose when the scan is over, of a scanner that moves while it scans. Beam i of n is taken at
  // the pose i/n of the way there; beams within a degree share one.
  std::optional<Rigid3> map_from_sensor_at_end = {};
};

struct ScanGrid {
  OccupancyGrid grid;
  std::size_t num_beams = 0;
  std::size_t num_hits = 0;
};

// Projects the beams onto the x-y plane of the map; the scanner's plane is level but for the tilt
// of a robot that drives on a floor. A range of at least min_range_m and below limit_m is measured.
// It is a hit below max_range_m; a longer one clears the cells up to max_range_m, because an error
// of the heading moves its end too far. Other ranges (NaN, zero or below, the limit) say nothing,
// because glass and black things return nothing either; with a clear_range_m, beams that report the
// limit or more clear the cells up to it.
//
// A scan raises the log-odds of each cell in which a beam ends, and lowers those of each other cell
// that a beam passes (WalkCells), once per scan: beams of one scan share its pose error, so
// they are no independent evidence. Cells that no scan changed are unknown. Range noise (1 to 3 cm)
// is not spread over cells, since it is less than a cell; with `thin_walls`, one of the cells
// across a wall stays occupied (thin_walls.h).
//
// A limit of the log-odds bounds what a cell remembers: 14 is 35 scans in a row that pass an
// occupied cell, or 17 that hit a free one. So a robot or a person that stands still for minutes
// outvotes nobody.
//
// Takes 14 bytes per cell of the box around all hits, whatever the number of scans; cells end at
// multiples of resolution_m. Pure: equal scans in equal order give equal cells. Throws DataError
// naming the remedy when there is no hit, or the box has more than 4e8 cells.
ScanGrid GridOfScans(const ScanGridOptions& options, std::span<const PlacedScan> scans);

}  // namespace nightmap
