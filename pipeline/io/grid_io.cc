// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/grid_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/map_yaml.h"

namespace nightmap {
namespace {

// Beyond these limits a distance in cells does not fit an integer.
constexpr int kMaxSide = 32767;  // cells; keeps every squared distance within 32 bits
constexpr double kMinResolution_m = 1e-3;
constexpr double kMaxResolution_m = 100;
constexpr double kMaxOrigin_m = 1e8;  // up to here a double resolves micrometres
constexpr double kMaxYaw_rad = 6.3;
constexpr std::array<std::uint8_t, 3> kGrayOfCell = {254, 0, 205};

struct Thresholds {
  bool is_raw = false;  // gray values are percentages; more than 100 is unknown
  bool negate = false;
  double occupied = 0.65;
  double free = 0.196;
};

// Accepts 0 and 1, and Nav2's false and true.
bool ReadNegate(const MapYaml& yaml, const std::string& path) {
  const std::string& text = yaml.Text("negate");
  if (text == "false" || text == "true") return text == "true";
  const double negate = yaml.Number("negate");
  if (negate != 0 && negate != 1) throw DataError("{}: negate is {}, not 0 or 1", path, negate);
  return negate == 1;
}

Thresholds ReadThresholds(const MapYaml& yaml, const std::string& path) {
  const std::string mode = yaml.Has("mode") ? yaml.Text("mode") : "trinary";
  if (mode != "trinary" && mode != "scale" && mode != "raw") {
    throw DataError("{}: mode is '{}', not trinary, scale or raw", path, mode);
  }
  const Thresholds thresholds{mode == "raw",
                              ReadNegate(yaml, path),
                              yaml.Fraction("occupied_thresh"),
                              yaml.Fraction("free_thresh")};
  if (thresholds.free > thresholds.occupied) {
    throw DataError("{}: free_thresh {} is above occupied_thresh {}",
                    path,
                    thresholds.free,
                    thresholds.occupied);
  }
  return thresholds;
}

// Reads the next number of a PNM header; comments run from # to the end of the line.
int HeaderNumber(const std::string& bytes,
                 std::size_t& at,
                 const std::string& path,
                 const char* field) {
  while (at < bytes.size() &&
         (std::isspace(static_cast<unsigned char>(bytes[at])) != 0 || bytes[at] == '#')) {
    at = bytes[at] == '#' ? std::min(bytes.find('\n', at), bytes.size()) : at + 1;
  }
  int value = 0;
  const auto [end, error] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), value);
  if (error != std::errc() || value < 1 || value > kMaxSide) {
    throw DataError("{}: {} in the PGM header is not a number in [1, {}]", path, field, kMaxSide);
  }
  at = static_cast<std::size_t>(end - bytes.data());
  return value;
}

struct Pgm {
  int width = 0;
  int height = 0;
  std::string pixels;  // row by row, top first
};

Pgm ReadPgm(const std::filesystem::path& path) {
  const std::string name = path.string();
  const std::string bytes = ReadFile(path);
  if (!bytes.starts_with("P5")) {
    throw DataError("{}: not a P5 PGM image; convert the map's image to binary PGM", name);
  }
  std::size_t at = 2;
  Pgm pgm;
  pgm.width = HeaderNumber(bytes, at, name, "width");
  pgm.height = HeaderNumber(bytes, at, name, "height");
  const int max_value = HeaderNumber(bytes, at, name, "maxval");
  if (max_value != 255) throw DataError("{}: maxval is {}, not 255", name, max_value);
  ++at;  // the single white space before the pixels
  const std::size_t expected =
      static_cast<std::size_t>(pgm.width) * static_cast<std::size_t>(pgm.height);
  const std::size_t actual = bytes.size() - std::min(at, bytes.size());
  if (actual != expected) {
    throw DataError("{}: {} pixels of {} x {} expected, {} bytes found: {}",
                    name,
                    expected,
                    pgm.width,
                    pgm.height,
                    actual,
                    actual < expected ? "truncated" : "too long");
  }
  pgm.pixels = bytes.substr(at);
  return pgm;
}

std::uint8_t Classify(int gray, const Thresholds& thresholds) {
  if (thresholds.is_raw && gray > 100) return kUnknownCell;
  const double occupied =
      thresholds.is_raw ? gray / 100.0 : (thresholds.negate ? gray : 255 - gray) / 255.0;
  if (occupied > thresholds.occupied) return kOccupiedCell;
  return occupied < thresholds.free ? kFreeCell : kUnknownCell;
}

std::filesystem::path ImagePath(const MapYaml& yaml, const std::filesystem::path& yaml_path) {
  return yaml_path.parent_path() / yaml.Text("image");  // operator/ keeps an absolute path
}

}  // namespace

Eigen::Vector2i OccupancyGrid::CellOf(const Eigen::Vector2d& point_in_map) const {
  // Clamped so that a point far outside does not overflow the integer.
  const auto floor_to_int = [](double value) {
    return static_cast<int>(std::floor(std::clamp(value, -1e9, 1e9)));
  };
  const Eigen::Vector2d point = ToCells(point_in_map);
  return {floor_to_int(point.x()), floor_to_int(point.y())};
}

GrayImage GridToImage(const OccupancyGrid& grid) {
  GrayImage image{grid.width, grid.height, 1, {}};
  image.pixels.reserve(grid.cells.size());
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      image.pixels.push_back(kGrayOfCell.at(grid.cells[grid.Index(x, y)]));
    }
  }
  return image;
}

std::string GridToPgm(const OccupancyGrid& grid) {
  const GrayImage image = GridToImage(grid);
  std::string bytes = fmt::format("P5\n{} {}\n255\n", grid.width, grid.height);
  bytes.append(image.pixels.begin(), image.pixels.end());
  return bytes;
}

std::string GridToYaml(const OccupancyGrid& grid, const std::string& image_name) {
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {}\norigin: [{}, {}, {}]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
      image_name,
      grid.resolution_m,
      grid.origin_in_map.x(),
      grid.origin_in_map.y(),
      grid.origin_yaw_rad);
}

std::filesystem::path GridImagePath(const std::filesystem::path& yaml_path) {
  return ImagePath(MapYaml(yaml_path), yaml_path);
}

OccupancyGrid ReadGrid(const std::filesystem::path& yaml_path) {
  const std::string name = yaml_path.string();
  const MapYaml yaml(yaml_path);
  OccupancyGrid grid;
  grid.resolution_m = yaml.Number("resolution");
  if (grid.resolution_m < kMinResolution_m || grid.resolution_m > kMaxResolution_m) {
    throw DataError("{}: resolution is {} m, not in [{}, {}]: give metres per cell",
                    name,
                    grid.resolution_m,
                    kMinResolution_m,
                    kMaxResolution_m);
  }
  const Eigen::Vector3d origin = yaml.Triple("origin");
  grid.origin_in_map = origin.head<2>();
  grid.origin_yaw_rad = origin.z();
  if (grid.origin_in_map.cwiseAbs().maxCoeff() > kMaxOrigin_m ||
      std::abs(grid.origin_yaw_rad) > kMaxYaw_rad) {
    throw DataError(
        "{}: origin is [{}, {}, {}]: give x and y in metres, at most {}, and the yaw in radians, "
        "at most a turn",
        name,
        origin.x(),
        origin.y(),
        origin.z(),
        kMaxOrigin_m);
  }
  const Thresholds thresholds = ReadThresholds(yaml, name);

  const Pgm pgm = ReadPgm(ImagePath(yaml, yaml_path));
  grid.width = pgm.width;
  grid.height = pgm.height;
  grid.cells.resize(pgm.pixels.size());
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const auto gray = static_cast<std::uint8_t>(pgm.pixels[grid.Index(x, grid.height - 1 - y)]);
      grid.cells[grid.Index(x, y)] = Classify(gray, thresholds);
    }
  }
  return grid;
}

}  // namespace nightmap
