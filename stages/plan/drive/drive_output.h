// SPDX-License-Identifier: Apache-2.0
// The drive stage's artifacts: drive.csv, drive.json and drive.gif.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/io/image_io.h"
#include "stages/plan/drive/drive.h"

namespace nightmap {

// Header time_ns,x_m,y_m,heading_rad,v_m_s,omega_rad_s; map frame, one row per control period, from
// time 0. Poses are the true ones. A row's command holds until the next row's time; the last
// command is zero. Commands have all their digits; poses are rounded to micrometres and
// microradians.
std::string DriveToCsv(const DriveResult& result);

// The drive's figures, for report.json.
nlohmann::ordered_json DriveFigures(const DriveResult& result);

// Format nightmap_drive, version 1: the figures and the config.
nlohmann::ordered_json DriveToJson(const DriveResult& result, const std::string& config_toml);

// The drive in equal time steps, at most kMaxDriveImages. Each picture shows the grid (white free,
// black occupied, grey unknown), the path, the part driven so far, and the robot with its heading;
// y up.
constexpr int kMaxDriveImages = 40;
constexpr double kDriveImagesPerS = 10;
std::vector<ColorImage> DrawDrive(const DriveInputs& inputs, const DriveResult& result);

}  // namespace nightmap
