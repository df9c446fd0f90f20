// SPDX-License-Identifier: Apache-2.0
// The meaning of a pixel of a ROS map's picture for its cell, by the rules of Nav2's map_server.
#pragma once

#include <cstdint>

#include "pipeline/io/yaml_map.h"

namespace nightmap {

enum class MapMode { kTrinary, kScale, kRaw };

// Statements of a map's YAML on the picture's values. Throws DataError naming file and line.
struct MapValues {
  explicit MapValues(const YamlMap& yaml);

  MapMode mode = MapMode::kTrinary;
  bool negate = false;
  double occupied_thresh = 0;
  double free_thresh = 0;
};

// The values of a pixel are those of ReadChannels: scaled to 16 bits, alpha last.
class MapPixels {
 public:
  static constexpr int kUnseenGray = 205;  // map_saver gives it to unseen space

  MapPixels(const MapValues& values, int num_channels);

  std::uint8_t CellOf(const std::uint16_t* pixel) const;  // CellValue
  // Whether the colors are those of unseen space, and the cell is free all the same.
  bool IsUnseenButFree(const std::uint16_t* pixel) const;
  bool HasAlpha() const { return has_alpha_; }

 private:
  int SumOfColors(const std::uint16_t* pixel) const;
  double OccupancyOf(int sum, int max) const;
  double Occupancy(const std::uint16_t* pixel) const;
  std::uint8_t CellOf(double occupancy) const;

  MapValues values_;
  int num_colors_;
  bool has_alpha_;
};

}  // namespace nightmap
