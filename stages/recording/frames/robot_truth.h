// SPDX-License-Identifier: Apache-2.0
// Where the robot truly was, by what [robot_truth] of a site config names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/recording/signals_io.h"
#include "pipeline/recording/site_config.h"

namespace nightmap {

struct RobotTruth {
  std::vector<StampedPose> truth_from_robot;  // times increase; empty: none
  std::string relations;                      // text of the file of relations; empty: none
  std::size_t num_relations = 0;
};

// Reads the truth. `signals` are those of all sensors of the site. The sensor that is the truth
// goes out of them, so that nothing takes it for what the robot measured. Relations are the lines
// `time1 time2 x y z roll pitch yaw` (s, m, rad: the second pose seen from the first) of Kuemmerle
// et al., "On measuring the accuracy of SLAM algorithms" (2009); they are copied as they are.
// Throws DataError naming file, line and remedy when a file cannot be read or holds no truth, or
// the sensor has no sample. Deterministic.
RobotTruth TakeRobotTruth(const SiteConfig& site,
                          const std::filesystem::path& data_root,
                          std::vector<Signal>* signals);

}  // namespace nightmap
