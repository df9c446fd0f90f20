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
  std::string scan_sensor;
  std::string message = "FLASER";
  double max_gap_s = 0.5;
  double max_failed_ratio = 0.2;

  void Register(OptionList& list);
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
