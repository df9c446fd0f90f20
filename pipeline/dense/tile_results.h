// SPDX-License-Identifier: Apache-2.0
// Results of a stage's runs on single tiles, for the stage that joins them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/dense/tile_config.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {

struct TileResults {
  TileConfig config;
  std::size_t num_keyframes = 0;  // over all tiles, each keyframe counted once
  // Unreadable keyframes. Every tile that lists one skips it for the same reason; it is counted
  // once.
  SkippedItems skipped;
  std::string first_depth_path;
};

// Reads the tiles' lists and the reports of their runs, at least one. Counts the keyframes that
// keyframe_stride of the tiles' config selects. Throws DataError naming the file.
TileResults ReadTileResults(const std::vector<std::filesystem::path>& tiles,
                            const std::vector<std::filesystem::path>& reports);

// Likewise for a stage that joins its inputs `part`, one for each of its inputs tile and
// tile_report. Also throws UsageError when their numbers differ, DataError when more than
// max_failed_ratio of the keyframes could not be read.
TileResults CheckTileParts(const StageContext& context,
                           const std::string& part,
                           double max_failed_ratio);

// Sums a count over all reports. Throws DataError naming the file that lacks it.
std::size_t SumOfReports(const std::vector<std::filesystem::path>& reports,
                         const std::string& count);

// Removes the files of vanished tiles from a folder: tile_X_Y.*, places_X_Y.csv, report_X_Y.json
// and receipt_X_Y.json of any X_Y other than those of the lists `tiles` (tile_X_Y.json).
void RemoveOtherTiles(const std::filesystem::path& folder,
                      const std::vector<std::filesystem::path>& tiles);

}  // namespace nightmap
