// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/camera_masks.h"

#include <algorithm>
#include <memory>

#include "pipeline/base/error.h"
#include "pipeline/io/camera_images.h"
#include "pipeline/io/resize_picture.h"

namespace nightmap {
namespace {

constexpr std::uint8_t kMidGray = 128;

GrayImage ReadMask(const RgbdCamera& camera, const std::filesystem::path& path) {
  const ColorImage picture = ReadColorOf(camera.Picture(), path);
  GrayImage mask = SampleImage(ToGray(picture), camera.color.width, camera.color.height);
  for (std::uint8_t& pixel : mask.pixels) pixel = pixel >= kMidGray ? 255 : 0;
  const auto num_masked = std::ranges::count(mask.pixels, 255);
  if (num_masked == 0) {
    throw DataError("{}: has no white pixel, so it masks nothing: paint the robot white",
                    path.string());
  }
  if (num_masked == std::ssize(mask.pixels)) {
    throw DataError("{}: all of it is white, so nothing is left to map: paint the world black",
                    path.string());
  }
  return mask;
}

}  // namespace

void ReadCameraMasks(const std::filesystem::path& data_root, SiteConfig* site) {
  for (const CameraMaskConfig& config : site->masks) {
    RgbdCamera& camera = site->cameras[static_cast<std::size_t>(config.camera_idx)];
    const std::filesystem::path file = std::filesystem::path(site->root) / config.file;
    try {
      const auto path = data_root / file.lexically_normal();
      camera.mask = std::make_shared<GrayImage>(ReadMask(camera, path));
    } catch (const DataError& error) {
      throw DataError("{}: mask = \"{}\": {}", config.source, config.file, error.what());
    }
  }
}

}  // namespace nightmap
