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

void MaskUnseen(RgbdCamera* camera) {
  const Camera& color = camera->color;
  if (!color.HasDistortion()) return;
  GrayImage mask{color.width, color.height, 1, {}};
  mask.pixels.resize(static_cast<std::size_t>(color.width) *
                     static_cast<std::size_t>(color.height));
  if (camera->mask) mask = *camera->mask;
  std::size_t num_unseen = 0;
  for (int y = 0; y < color.height; ++y) {
    for (int x = 0; x < color.width; ++x) {
      if (color.Sees(Eigen::Vector2d(x, y))) continue;
      mask.At(x, y) = 255;
      ++num_unseen;
    }
  }
  if (num_unseen == mask.pixels.size()) {
    throw DataError(
        "camera \"{}\": its lens has no ray for any pixel, so nothing is left to map: correct its "
        "cx, cy, fx, fy and distortion",
        camera->camera_id);
  }
  if (num_unseen > 0) camera->mask = std::make_shared<GrayImage>(std::move(mask));
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
  for (RgbdCamera& camera : site->cameras) MaskUnseen(&camera);
}

}  // namespace nightmap
