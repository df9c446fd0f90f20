// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/import_grid/import_grid.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "pipeline/base/input_error.h"

namespace nightmap {

void CheckPlace(const OccupancyGrid& grid,
                const std::vector<StampedPose>& trajectory,
                const std::string& file) {
  std::size_t num_known = 0;
  std::size_t num_free = 0;
  for (const StampedPose& stamped : trajectory) {
    const Eigen::Vector2i cell = grid.CellOf(stamped.pose.translation.head<2>());
    if (!grid.Contains(cell)) continue;
    num_known += grid.At(cell) != kUnknownCell;
    num_free += grid.At(cell) == kFreeCell;
  }
  const char* remedy =
      "give its origin [x, y, yaw] in the frame of the site's trajectory (map_frame's "
      "source = \"given\" keeps the frame of an imported one)";
  if (num_known == 0 && !trajectory.empty()) {
    throw DataError("{}: none of the {} camera poses is in its free or occupied cells: {}",
                    file,
                    trajectory.size(),
                    remedy);
  }
  if (2 * num_free < trajectory.size()) {
    spdlog::warn("{}: only {} of {} camera poses are in its free cells; if that is not so, {}",
                 file,
                 num_free,
                 trajectory.size(),
                 remedy);
  }
}

nlohmann::json RunImportGrid(const OccupancyGrid& grid) {
  const auto count = [&](CellValue value) { return std::ranges::count(grid.cells, value); };
  if (count(kFreeCell) == 0) {
    throw InputError(
        {{"map"}}, InputError::Remedy::kInText, "no cell is free; check free_thresh and negate");
  }
  return {{"num_free_cells", count(kFreeCell)},
          {"num_occupied_cells", count(kOccupiedCell)},
          {"resolution_m", grid.resolution_m}};
}

}  // namespace nightmap
