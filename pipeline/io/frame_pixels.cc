// SPDX-License-Identifier: Apache-2.0
// One frame's pixels, for frames_io.h.
#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/io/camera_images.h"
#include "pipeline/io/data_paths.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/masked_pixels.h"
#include "pipeline/io/resize_picture.h"

namespace nightmap {
namespace {

// Returns what `read` makes of a file in the data folder; its errors name the file as the lists do.
template <typename Read>
auto ReadFromData(const std::filesystem::path& data_root, const std::string& file, Read read) {
  try {
    return read(data_root / file);
  } catch (const DataError& error) {
    throw DataError("{}", WithoutDataRoot(error.what(), data_root, file));
  }
}

// First and last pixel that a footprint of `size` px around `center` covers: the pixels whose
// centre lies inside, at least the nearest one.
struct Span {
  int first;
  int last;
};
Span Footprint(double center, double size, int limit) {
  const int nearest = static_cast<int>(std::lround(center));
  const int first = std::min(nearest, static_cast<int>(std::ceil(center - size / 2)));
  const int last = std::max(nearest, static_cast<int>(std::ceil(center + size / 2)) - 1);
  return {std::max(first, 0), std::min(last, limit - 1)};
}

// Length of the ray through a pixel, where z is 1; pixels row by row.
double RayLength(const Camera& camera, std::size_t pixel) {
  const auto width = static_cast<std::size_t>(camera.width);
  const std::size_t column = pixel % width, row = pixel / width;
  return camera.BackProject({static_cast<double>(column), static_cast<double>(row)}, 1).norm();
}

void DrawNearest(DepthImage& image, Span columns, Span rows, float depth_m) {
  for (int y = rows.first; y <= rows.last; ++y) {
    for (int x = columns.first; x <= columns.last; ++x) {
      float& pixel = image.At(x, y);
      if (pixel == 0 || depth_m < pixel) pixel = depth_m;
    }
  }
}

// Nothing was measured where the confidence is too low.
void RemoveUnsure(const FrameRecord& frame,
                  const RgbdCamera& camera,
                  const std::filesystem::path& data_root,
                  DepthImage* depth) {
  const auto channel = frame.others.find(kConfidenceChannel);
  if (channel == frame.others.end()) {
    throw DataError(
        "{}: no picture of its confidence is listed: add confidence_folder to its "
        "[[sequence]]",
        frame.depth.path);
  }
  const LabelImage confidence =
      ReadFromData(data_root, channel->second.path, [&](const std::filesystem::path& path) {
        return ReadConfidenceOf(camera.DepthPicture(), path);
      });
  const int factor = depth->width / confidence.width;
  for (int y = 0; y < depth->height; ++y) {
    for (int x = 0; x < depth->width; ++x) {
      if (confidence.At(x / factor, y / factor) < camera.min_confidence) depth->At(x, y) = 0;
    }
  }
}

}  // namespace

Camera RgbdCamera::Picture() const {
  return picture_width > 0 ? ResizeCamera(color, picture_width, picture_height) : color;
}

void ReduceToWorkingSize(double working_mpx, RgbdCamera* camera) {
  const Camera& picture = camera->color;
  const double scale = std::sqrt(1e6 * working_mpx / picture.width / picture.height);
  if (scale >= 1) return;
  const auto reduced = [&](int size) {
    return std::max(1, static_cast<int>(std::lround(size * scale)));
  };
  camera->picture_width = picture.width;
  camera->picture_height = picture.height;
  camera->color = ResizeCamera(picture, reduced(picture.width), reduced(picture.height));
}

DepthImage RegisterDepth(const DepthImage& depth, const RgbdCamera& camera) {
  DepthImage registered{camera.color.width, camera.color.height, 1, {}};
  registered.pixels.assign(
      static_cast<std::size_t>(camera.color.width) * static_cast<std::size_t>(camera.color.height),
      0.0f);
  const double scale_x = camera.color.fx / camera.depth.fx;
  const double scale_y = camera.color.fy / camera.depth.fy;
  for (int y = 0; y < depth.height; ++y) {
    for (int x = 0; x < depth.width; ++x) {
      const double depth_m = depth.At(x, y);
      if (depth_m <= 0) continue;
      const auto point = camera.color_from_depth * camera.depth.BackProject({x, y}, depth_m);
      const auto pixel = camera.color.Project(point);
      if (!pixel || !camera.color.Contains(*pixel)) continue;
      const double growth = depth_m / point.z();
      DrawNearest(registered,
                  Footprint(pixel->x(), scale_x * growth, registered.width),
                  Footprint(pixel->y(), scale_y * growth, registered.height),
                  static_cast<float>(point.z()));
    }
  }
  return registered;
}

ColorImage LoadColor(const FrameRecord& frame,
                     const RgbdCamera& camera,
                     const std::filesystem::path& data_root) {
  ColorImage color =
      ReadFromData(data_root, frame.color.path, [&](const std::filesystem::path& path) {
        return ReadColorOf(camera.Picture(), path, camera.picture_bits);
      });
  if (camera.picture_width > 0) {
    color = ShrinkColor(color, camera.color.width, camera.color.height);
  }
  if (camera.mask) FadeOut(*camera.mask, &color);
  return color;
}

DepthImage LoadDepth(const FrameRecord& frame,
                     const RgbdCamera& camera,
                     const std::filesystem::path& data_root) {
  if (frame.depth.path.empty()) {
    throw DataError(
        "{}: frame has no depth, but this map needs it: set depth = \"required\" in the "
        "[[sequence]] to leave such frames out",
        frame.color.path);
  }
  DepthImage depth =
      ReadFromData(data_root, frame.depth.path, [&](const std::filesystem::path& path) {
        return ReadRawDepthOf(camera.DepthPicture(), path);
      });
  if (camera.min_confidence > 0) RemoveUnsure(frame, camera, data_root, &depth);
  const Camera& depth_camera = camera.depth_registered ? camera.color : camera.depth;
  depth = SampleImage(std::move(depth), depth_camera.width, depth_camera.height);
  const double units_per_m = camera.depth_units_per_m > 0 ? camera.depth_units_per_m : 1;
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
    float& pixel = depth.pixels[i];
    if (pixel == 0) continue;
    double depth_m = pixel / units_per_m - camera.depth_offset_m;
    if (camera.depth_along_ray) depth_m /= RayLength(depth_camera, i);
    // Not of NaN.
    const bool is_used = depth_m >= camera.min_depth_m && depth_m <= camera.max_depth_m;
    pixel = is_used ? static_cast<float>(depth_m) : 0;
  }
  if (!camera.depth_registered) depth = RegisterDepth(depth, camera);
  if (camera.mask) RemoveDepth(*camera.mask, &depth);
  return depth;
}

RgbdImages LoadRgbd(const FrameRecord& frame,
                    const RgbdCamera& camera,
                    const std::filesystem::path& data_root) {
  const bool has_depth = !frame.depth.path.empty();
  return {LoadColor(frame, camera, data_root),
          has_depth ? LoadDepth(frame, camera, data_root) : DepthImage{},
          camera.mask ? *camera.mask : GrayImage{}};
}

}  // namespace nightmap
