// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/map_pixels.h"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <map>
#include <numeric>

#include "pipeline/io/grid_io.h"

namespace nightmap {
namespace {

constexpr int kMaxValue = 65535;

// As Nav2, in letters of either case.
MapMode ReadMode(const YamlMap& yaml) {
  static const std::map<std::string, MapMode> modes = {
      {"trinary", MapMode::kTrinary}, {"scale", MapMode::kScale}, {"raw", MapMode::kRaw}};
  if (!yaml.Has("mode")) return MapMode::kTrinary;
  std::string mode = yaml.Text("mode");
  for (char& letter : mode) {
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  const auto found = modes.find(mode);
  if (found != modes.end()) return found->second;
  yaml.Fail("mode", fmt::format("mode is '{}', not trinary, scale or raw", yaml.Text("mode")));
}

}  // namespace

MapValues::MapValues(const YamlMap& yaml)
    : mode(ReadMode(yaml)),
      negate(yaml.Flag("negate")),
      occupied_thresh(yaml.Number("occupied_thresh", 0, 1)),
      free_thresh(yaml.Number("free_thresh", 0, 1)) {
  if (free_thresh <= occupied_thresh) return;
  yaml.Fail("free_thresh",
            fmt::format("free_thresh {} is above occupied_thresh {}: write those of map_server, "
                        "0.196 and 0.65",
                        free_thresh,
                        occupied_thresh));
}

MapPixels::MapPixels(const MapValues& values, int num_channels)
    : values_(values),
      num_colors_(num_channels < 3 ? 1 : 3),
      has_alpha_(num_channels > num_colors_) {}

std::uint8_t MapPixels::CellOf(const std::uint16_t* pixel) const {
  if (values_.mode == MapMode::kScale && has_alpha_ && pixel[num_colors_] < kMaxValue) {
    return kUnknownCell;
  }
  if (values_.mode != MapMode::kRaw) return CellOf(Occupancy(pixel));
  const double percent = std::round(SumOfColors(pixel) * 255.0 / (kMaxValue * num_colors_));
  if (percent > 100) return kUnknownCell;
  return CellOf(percent / 100);
}

bool MapPixels::IsUnseenButFree(const std::uint16_t* pixel) const {
  const double occupancy = OccupancyOf(SumOfColors(pixel), kMaxValue * num_colors_);
  return values_.mode == MapMode::kTrinary && std::round(255 * occupancy) == 255 - kUnseenGray &&
         CellOf(pixel) == kFreeCell;
}

int MapPixels::SumOfColors(const std::uint16_t* pixel) const {
  return std::accumulate(pixel, pixel + num_colors_, 0);
}

double MapPixels::OccupancyOf(int sum, int max) const {
  return static_cast<double>(values_.negate ? sum : max - sum) / max;
}

// Mode trinary counts alpha as a color. A gray picture with alpha has three equal colors then.
double MapPixels::Occupancy(const std::uint16_t* pixel) const {
  const int sum = SumOfColors(pixel);
  if (values_.mode != MapMode::kTrinary || !has_alpha_) {
    return OccupancyOf(sum, kMaxValue * num_colors_);
  }
  return OccupancyOf(sum * 3 / num_colors_ + pixel[num_colors_], 4 * kMaxValue);
}

std::uint8_t MapPixels::CellOf(double occupancy) const {
  if (occupancy > values_.occupied_thresh) return kOccupiedCell;
  return occupancy < values_.free_thresh ? kFreeCell : kUnknownCell;
}

}  // namespace nightmap
