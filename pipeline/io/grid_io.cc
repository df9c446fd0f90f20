// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/grid_io.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/io/map_pixels.h"
#include "pipeline/io/yaml_map.h"

namespace nightmap {
namespace {

// Beyond these limits a distance in cells does not fit an integer.
constexpr int kMaxSide = 32767;  // cells; keeps every squared distance within 32 bits
constexpr double kMinResolution_m = 1e-3;
constexpr double kMaxResolution_m = 100;
constexpr double kMaxOrigin_m = 1e8;  // up to here a double resolves micrometres
constexpr double kMaxYaw_rad = 6.3;
constexpr std::array<std::uint8_t, 3> kGrayOfCell = {254, 0, MapPixels::kUnseenGray};

Image<std::uint16_t> ReadMapImage(const std::filesystem::path& path) {
  Image<std::uint16_t> image = ReadChannels(path);
  if (image.width <= kMaxSide && image.height <= kMaxSide) return image;
  throw DataError("{}: {} x {} pixels, a map has at most {} a side: cut it or make it coarser",
                  path.string(),
                  image.width,
                  image.height,
                  kMaxSide);
}

void WarnOfUnseen(std::size_t num_unseen, const MapPixels& pixels, const std::string& file) {
  if (num_unseen == 0) return;
  spdlog::warn(
      "{}: {} cells of the gray that map_saver gives to unseen space are read as free: write "
      "free_thresh: 0.196{}",
      file,
      num_unseen,
      pixels.HasAlpha() ? " and save the picture without alpha, which counts as a color" : "");
}

std::filesystem::path ImagePath(const YamlMap& yaml, const std::filesystem::path& yaml_path) {
  const std::string image = yaml.Text("image");
  if (image.empty() || image.find('\0') != std::string::npos) {
    yaml.Fail("image", "image is not the name of a file: name the picture of the map");
  }
  return yaml_path.parent_path() / image;  // operator/ keeps an absolute path
}

void ReadPlace(const YamlMap& yaml, OccupancyGrid* grid) {
  grid->resolution_m = yaml.Number("resolution", kMinResolution_m, kMaxResolution_m);
  const std::vector<double> origin = yaml.Numbers("origin");
  if (origin.size() != 3 || std::abs(origin[0]) > kMaxOrigin_m ||
      std::abs(origin[1]) > kMaxOrigin_m || std::abs(origin[2]) > kMaxYaw_rad) {
    yaml.Fail("origin",
              fmt::format("origin is [{}]: give x and y in metres, at most {}, and the yaw in "
                          "radians, at most a turn",
                          fmt::join(origin, ", "),
                          kMaxOrigin_m));
  }
  grid->origin_in_map = {origin[0], origin[1]};
  grid->origin_yaw_rad = origin[2];
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
  return ImagePath(YamlMap(yaml_path), yaml_path);
}

OccupancyGrid ReadGrid(const std::filesystem::path& yaml_path) {
  const YamlMap yaml(yaml_path);
  OccupancyGrid grid;
  ReadPlace(yaml, &grid);
  const MapValues values(yaml);
  const auto image = ReadMapImage(ImagePath(yaml, yaml_path));
  grid.width = image.width;
  grid.height = image.height;
  grid.cells.reserve(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  const MapPixels pixels(values, image.num_channels);
  std::size_t num_unseen = 0;
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::uint16_t* pixel = &image.At(x, y);
      grid.cells.push_back(pixels.CellOf(pixel));
      num_unseen += pixels.IsUnseenButFree(pixel);
    }
  }
  WarnOfUnseen(num_unseen, pixels, yaml_path.string());
  return grid;
}

}  // namespace nightmap
