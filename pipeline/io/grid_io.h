// SPDX-License-Identifier: Apache-2.0
// 2-D occupancy grids in ROS map_server's format: a P5 PGM image and a small YAML file next to it.
// Also reads grids of other systems, whose image may be of any format that image_io.h reads.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

enum CellValue : std::uint8_t { kFreeCell = 0, kOccupiedCell = 1, kUnknownCell = 2 };

// Cells in the x-y plane of the map frame, row by row from cell (0, 0). The grid stage's own grids
// are not rotated: row 0 has the smallest y.
struct OccupancyGrid {
  int width = 0;
  int height = 0;
  double resolution_m = 0.05;                               // edge length of a cell
  Eigen::Vector2d origin_in_map = Eigen::Vector2d::Zero();  // lower left corner of cell (0, 0), m
  std::vector<std::uint8_t> cells;                          // CellValue
  double origin_yaw_rad = 0;  // from the map's x axis to the rows, counter-clockwise

  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
  bool Contains(const Eigen::Vector2i& cell) const {
    return cell.x() >= 0 && cell.y() >= 0 && cell.x() < width && cell.y() < height;
  }
  std::uint8_t At(const Eigen::Vector2i& cell) const { return cells[Index(cell.x(), cell.y())]; }
  // Point in units of cells: the centre of cell (x, y) is (x + 0.5, y + 0.5).
  Eigen::Vector2d ToCells(const Eigen::Vector2d& point_in_map) const {
    return Eigen::Rotation2Dd(-origin_yaw_rad) * (point_in_map - origin_in_map) / resolution_m;
  }
  Eigen::Vector2d FromCells(const Eigen::Vector2d& point_in_cells) const {
    return origin_in_map + Eigen::Rotation2Dd(origin_yaw_rad) * (resolution_m * point_in_cells);
  }
  // The cell that a point lies in; may be outside the grid.
  Eigen::Vector2i CellOf(const Eigen::Vector2d& point_in_map) const;
  Eigen::Vector2d CenterInMap(const Eigen::Vector2i& cell) const {
    return FromCells(cell.cast<double>() + Eigen::Vector2d(0.5, 0.5));
  }
};

// 254 free, 0 occupied, 205 unknown; the top row of the image has the largest y.
GrayImage GridToImage(const OccupancyGrid& grid);

// The same image as the bytes of a P5 file.
std::string GridToPgm(const OccupancyGrid& grid);

// The YAML text for the image. `image_name` is the PGM's path relative to the YAML's folder.
// Numbers are printed so that reading gives the same double.
std::string GridToYaml(const OccupancyGrid& grid, const std::string& image_name);

// The PGM's path that a map YAML names, relative names resolved against the YAML's folder.
std::filesystem::path GridImagePath(const std::filesystem::path& yaml_path);

// Reads the YAML and its image as Nav2's map_server does. v is the mean of a pixel's colors, from 0
// to 1: p = 1 - v, or v with negate; p > occupied_thresh is occupied, p < free_thresh free, the
// rest unknown. Mode `trinary` counts alpha as a color. In mode `scale` what is not opaque is
// unknown, and so is a value between the thresholds, because it is neither surely free nor surely
// occupied. In mode `raw` p = 2.55 v, and p > 1 is unknown. An origin with a yaw rotates the grid
// about its lower left corner. Keys beside those of map_server are ignored. Warns when free_thresh
// takes the gray of unseen space for free. Throws DataError naming file and line on a missing,
// repeated or malformed key, NaN or another mode, and naming the image when it cannot be read.
OccupancyGrid ReadGrid(const std::filesystem::path& yaml_path);

}  // namespace nightmap
