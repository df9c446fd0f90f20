// SPDX-License-Identifier: Apache-2.0
// The files of the frames stage.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/io/frames_io.h"
#include "pipeline/program/stage_main.h"
#include "pipeline/recording/finish_scans.h"
#include "pipeline/recording/signals_io.h"
#include "stages/recording/frames/frames.h"
#include "stages/recording/frames/robot_truth.h"

namespace nightmap {

// Reports, and warns of, frames that max_frames leaves out.
void ReportLeftOut(const FramesOptions& options, std::size_t num_left_out, nlohmann::json& report);

// Reports, and warns of, the samples of each sensor that got another time (line_clock.h).
void ReportTimesInLineOrder(const SiteConfig& site,
                            const std::vector<std::size_t>& num_in_line_order,
                            nlohmann::json& report);

// Reports what scans tell of their scanners, and warns of what their descriptions should say
// (finish_scans.h): "range_of_no_hit_m" of a scanner, and its "robot_body" where that can be told.
void ReportFoundInScans(const SiteConfig& site,
                        const std::vector<FoundInScans>& found,
                        nlohmann::json& report);

// Reports, and warns of, odometry that hardly overlaps with scans in time (common_time.h).
void ReportApart(const std::vector<std::string>& apart, nlohmann::json& report);

// Skips, in the report, the frames of `lists` and the `problems` of signals. Throws DataError when
// more than max_failed_ratio of the frames failed.
void ReportSkipped(const FramesOptions& options,
                   const FrameLists& lists,
                   const std::vector<std::string>& problems,
                   StageContext& context);

// Throws DataError naming the folder of the recordings when no frame is left.
void CheckAnyIsLeft(const FrameLists& lists, const std::filesystem::path& data_root);

// Writes next to the output `shards`: the shards, held-out frames, cameras, truth, and the signals
// of each kind. A file whose bytes did not change is left untouched. Writes shards.txt last and
// fills the report. Removes files of an earlier run that this run does not have (shards beyond the
// last, truth of a site without any). The camera_idx of `lists` are indices into `cameras`. So are
// those of the written held-out frames, whose cameras the site config describes; those of the
// written shards are indices into cameras.json.
void WriteFrames(const FramesOptions& options,
                 const std::vector<RgbdCamera>& cameras,
                 FrameLists lists,
                 const std::vector<Signal>& signals,
                 const RobotTruth& robot_truth,
                 StageContext& context);

}  // namespace nightmap
