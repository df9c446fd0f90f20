// SPDX-License-Identifier: Apache-2.0
// What the runs of a stage on single tiles left, for the stage that joins them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/io/tile_config.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {

struct TileResults {
  TileConfig config;
  std::size_t num_keyframes = 0;  // of all tiles, each counted once
  // Those that could not be read. Every tile that lists one skips it for the same reason; it is
  // counted once.
  SkippedItems skipped;
  std::string first_depth_path;
};

// From the lists of the tiles, of which the keyframes that keyframe_stride of the tiles' config
// takes were used, and the reports of their runs, at least one. Throws DataError naming the file.
TileResults ReadTileResults(const std::vector<std::filesystem::path>& tiles,
                            const std::vector<std::filesystem::path>& reports);

// The same of a stage that joins its inputs `part`, one for each of its inputs tile and
// tile_report. Throws also UsageError when there are not as many of each, DataError when more than
// max_failed_ratio of the keyframes could not be read.
TileResults CheckTileParts(const StageContext& context,
                           const std::string& part,
                           double max_failed_ratio);

// Of a count that every report has, the sum. Throws DataError naming the file without it.
std::size_t SumOfReports(const std::vector<std::filesystem::path>& reports,
                         const std::string& count);

// Removes from a folder what was made of tiles that are no more: tile_X_Y.*, report_X_Y.json and
// receipt_X_Y.json of any X_Y but those of the lists `tiles`, tile_X_Y.json.
void RemoveOtherTiles(const std::filesystem::path& folder,
                      const std::vector<std::filesystem::path>& tiles);

}  // namespace nightmap
