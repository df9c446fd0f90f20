// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/resize_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace nightmap {

Camera ResizeCamera(const Camera& camera, int width, int height) {
  const double scale_x = static_cast<double>(width) / camera.width;
  const double scale_y = static_cast<double>(height) / camera.height;
  Camera resized = camera;
  resized.width = width;
  resized.height = height;
  resized.fx = camera.fx * scale_x;
  resized.fy = camera.fy * scale_y;
  resized.cx = (camera.cx + 0.5) * scale_x - 0.5;
  resized.cy = (camera.cy + 0.5) * scale_y - 0.5;
  return resized;
}

Eigen::Vector2d ResizePixel(const Eigen::Vector2d& pixel, const Camera& from, const Camera& to) {
  if (from.width == to.width && from.height == to.height) return pixel;  // to the last bit
  return {(pixel.x() + 0.5) * to.width / from.width - 0.5,
          (pixel.y() + 0.5) * to.height / from.height - 0.5};
}

CameraPicture ShrinkPicture(const ColorImage& color, const Camera& camera, double scale) {
  const auto shrunk = [&](int size) {
    return std::max(1, static_cast<int>(std::lround(size * scale)));
  };
  CameraPicture result{ShrinkColor(color, shrunk(color.width), shrunk(color.height)), {}};
  result.camera = ResizeCamera(camera, result.color.width, result.color.height);
  return result;
}

ColorImage ShrinkColor(const ColorImage& color, int width, int height) {
  ColorImage shrunk{width, height, 3, {}};
  shrunk.pixels.resize(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  // OpenCV takes no pointer to constant pixels, but it only reads these.
  const cv::Mat from(
      color.height, color.width, CV_8UC3, const_cast<std::uint8_t*>(color.pixels.data()));
  cv::Mat to(height, width, CV_8UC3, shrunk.pixels.data());
  cv::resize(from, to, to.size(), 0, 0, cv::INTER_AREA);
  return shrunk;
}

}  // namespace nightmap
