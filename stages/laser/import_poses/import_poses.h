// SPDX-License-Identifier: Apache-2.0
// import_poses: takes the robot's poses that another system made of a laser log.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/recording/signals_io.h"

namespace nightmap {

struct ImportPosesOptions {
  OPTION(std::string, scan_sensor, "", "id of the sensor; empty: the only one that scans");
  OPTION(std::string, message, "FLASER", "lines of a CARMEN log whose poses are taken");
  OPTION(double, max_gap_s, 0.5, {0, 10},
         "a scan between two poses has one only if they are at most this far apart");
  OPTION(double, max_failed_ratio, 0.2, {0, 1},
         "fails when a larger share of the scans has no pose, or of the lines is damaged");
  REGISTER_OPTIONS();
};

struct ImportPosesInput {
  std::vector<Signal> scans;       // of all sensors of the site
  std::vector<StampedPose> given;  // given_from_robot, ascending in time
};

struct ImportPosesResult {
  std::vector<StampedPose> poses;    // given_from_robot at each scan that has one
  std::vector<std::string> skipped;  // "scan at TIME: cause"
  std::size_t num_scans = 0;
};

// Reads poses from a TUM file (.tum, .txt), or those of a CARMEN log whose lines `message` were
// corrected (any other name; may be gzipped). Throws DataError naming file and line, as ReadTum and
// ReadSensorSignals do.
std::vector<StampedPose> ReadGivenPoses(const ImportPosesOptions& options,
                                        const std::filesystem::path& path);

// Reads a TUM file; which lines of a log are meant, only the options tell. Throws DataError.
void CheckGivenPoses(const std::filesystem::path& path);

// The poses at the times of the scans, interpolated between two given ones at most max_gap_s apart.
// The map frame is that of the poses. Throws UsageError when a sensor is not named but must be,
// InputError when no scan has a pose. Pure.
ImportPosesResult RunImportPoses(const ImportPosesOptions& options, const ImportPosesInput& input);

}  // namespace nightmap
