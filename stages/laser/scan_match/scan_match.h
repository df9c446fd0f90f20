// SPDX-License-Identifier: Apache-2.0
// scan_match: the robot's way through a recording of laser scans, by matching each scan to those
// shortly before it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/geometry/rigid2.h"
#include "pipeline/io/edges_io.h"
#include "pipeline/laser/likelihood_field.h"
#include "pipeline/recording/wheel_edges.h"

namespace nightmap {

struct ScanMatchOptions {
  OPTION(std::string, scan_sensor, "", "id of the sensor; empty: the only one that scans");
  OPTION(std::string, odometry_sensor, "",
         "id of the wheels' odometry; empty: the only one of the site; none: without");
  LikelihoodFieldOptions field;
  OPTION_AT("resolution_m", field.resolution_m, {0.01, 1}, "cells of the likelihood field");
  OPTION_AT("half_extent_m", field.half_extent_m, {1, 500},
            "of the field around the first scan of a submap");
  OPTION_AT("sigma_m", field.sigma_m, {0.01, 1},
            "standard deviation between two measurements of a wall");
  OPTION(double, max_range_m, 30, {1, 500}, "points farther away are not used");
  OPTION(double, keyscan_distance_m, 0.15, {0, 100}, "a scan enters the submap after such a way");
  OPTION(double, keyscan_angle_rad, 0.1, {0, 7}, "... or after such a turn");
  OPTION(int, min_points, 20, {3, 100000}, "a scan with fewer points is not matched");
  OPTION(double, min_score, 0.3, {0, 1},
         "a scan that fits worse keeps its prediction; 1: each point on an earlier one");
  OPTIONS_OF(WheelNoise, wheels);
  OPTION(double, walking_sigma_m_per_s, 0.5, {0.001, 100},
         "deviation from the last motion, without odometry");
  OPTION(double, walking_sigma_rad_per_s, 0.5, {0.001, 100}, "likewise");
  OPTION(double, max_failed_ratio, 0.2, {0, 1},
         "fails when a larger share of the scans does not fit");

  ScanMatchOptions();
  REGISTER_OPTIONS();
};

struct ScanMatchInput {
  std::vector<Signal> scans;     // of all sensors of the site
  std::vector<Signal> odometry;  // may be empty
};

// A scan and where the robot was when it was taken.
struct MatchedScan {
  std::int64_t time_ns = 0;
  Rigid2 start_from_robot;  // in the frame of the robot at the first scan
  double score = 0;         // mean of the likelihood field at its points, 0 .. 1
  bool is_matched = false;  // otherwise the pose is the prediction
  bool is_keyscan = false;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  // of a keyscan, since the one before
  std::optional<Rigid2> last_from_robot_by_wheels;       // since the scan before
  // The direction, in the robot's axes, along which the scan would fit as well elsewhere, so that
  // the wheels alone tell the way.
  std::optional<Eigen::Vector2d> unclear_in_robot;
};

struct ScanMatchResult {
  std::string scan_sensor;
  std::string odometry_sensor;  // empty: without
  std::vector<MatchedScan> scans;
  std::optional<double> wheel_scale;  // metres of walls over metres of wheels (unclear_ways.h)
  // Between consecutive keyscans, of the robot.
  SensorEdges edges;
};

// Predicts each scan's pose by the wheels' odometry, or without one by the last motion, searches
// around the prediction in the likelihood field of the submap, and refines what is found
// (match_scan.h). A scan that fits nowhere keeps its prediction; when the robot has moved on, new
// submaps begin at such a scan, and the edge to it has the predictions' uncertainty. The floors of
// the wheels' noise are per scan and large, because wheels slip and have another clock, and so the
// search finds a robot that goes elsewhere than its wheels say. Along the axis of a bare corridor
// no wall tells the way (UnclearDirection in match_scan.h): there the robot goes as far as the
// wheels say, at the scale that the wheels have where walls tell the way (unclear_ways.h). The
// points of a scan that takes a while (scan_duration_s) are moved to where the robot is at the
// scan's time, by the wheels or by the last motion. After a pause without scans and wheels the
// robot stands where it stood, where that is sure, or a part of its own begins, whose edge has no
// knowledge and which loops join (scan_loops). Keyscans, chosen by motion, make the submap: there
// are two that overlap by half, and matching uses the older one, as Cartographer does (Hess,
// Kohler, Rapp, Andor, Real-time loop closure in 2D LIDAR SLAM, ICRA 2016). So time per scan and
// memory do not grow with the recording. Throws UsageError when a sensor is named that the site has
// not, or none among several, InputError when there is no scan. Deterministic; one thread.
ScanMatchResult RunScanMatch(const ScanMatchOptions& options,
                             const ScanMatchInput& input,
                             Progress& progress);

}  // namespace nightmap
