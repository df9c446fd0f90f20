// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/texture_mesh/picture_chart.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace nightmap {
namespace {

// Viewers mix a texel with those beside it, the more the smaller they draw it.
constexpr int kGutter_px = 2;
// A chart of few vertices has hardly a mean: the gain is drawn to 1 by so many gray ones.
constexpr double kNumGray = 8, kGray = 128;

Eigen::Array3d ColorAt(const ColorImage& color, const Eigen::Vector2d& pixel) {
  const double x = std::clamp(pixel.x(), 0.0, color.width - 1.0);
  const double y = std::clamp(pixel.y(), 0.0, color.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), std::max(color.width - 2, 0));
  const int y0 = std::min(static_cast<int>(y), std::max(color.height - 2, 0));
  const int x1 = std::min(x0 + 1, color.width - 1), y1 = std::min(y0 + 1, color.height - 1);
  const double right = x - x0, low = y - y0;
  Eigen::Array3d rgb;
  for (int c = 0; c < 3; ++c) {
    rgb[c] = (1 - low) * ((1 - right) * color.At(x0, y0, c) + right * color.At(x1, y0, c)) +
             low * ((1 - right) * color.At(x0, y1, c) + right * color.At(x1, y1, c));
  }
  return rgb;
}

Eigen::Array3d GainOf(const TileMesh& mesh, const PictureChart& chart, const ColorImage& color) {
  Eigen::Array3d wanted = Eigen::Array3d::Constant(kNumGray * kGray), found = wanted;
  for (std::size_t i = 0; i < chart.vertices.size(); ++i) {
    const auto& rgb = mesh.vertices[chart.vertices[i]].rgb;
    wanted += Eigen::Array3d(rgb[0], rgb[1], rgb[2]);
    found += ColorAt(color, chart.pixels[i]);
  }
  return (wanted / found).max(0.5).min(2.0);
}

// Pixels per metre on the mean triangle.
double PixelsPerMetre(const TileMesh& mesh, const PictureChart& chart) {
  double area_px2 = 0, area_m2 = 0;
  for (const auto& [a, b, c] : chart.triangles) {
    const Eigen::Vector2d ab = chart.pixels[b] - chart.pixels[a];
    const Eigen::Vector2d ac = chart.pixels[c] - chart.pixels[a];
    area_px2 += std::abs(ab.x() * ac.y() - ab.y() * ac.x());
    const auto at = [&](std::uint32_t i) {
      return mesh.vertices[chart.vertices[i]].position_in_map.cast<double>().eval();
    };
    area_m2 += (at(b) - at(a)).cross(at(c) - at(a)).norm();
  }
  return area_m2 > 0 ? std::sqrt(area_px2 / area_m2) : 0;
}

}  // namespace

PictureChart ChartWithoutPicture(const TileMesh& mesh, const ViewChart& chart) {
  PictureChart made;
  std::unordered_map<std::uint32_t, std::uint32_t> index;
  for (const std::uint32_t triangle : chart.triangles) {
    Triangle& corners = made.triangles.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = mesh.triangles[triangle][k];
      const auto [at, is_new] =
          index.insert({vertex, static_cast<std::uint32_t>(made.vertices.size())});
      if (is_new) made.vertices.push_back(vertex);
      corners[k] = at->second;
    }
  }
  return made;
}

PictureChart ChartInPicture(const TileMesh& mesh,
                            const ViewChart& chart,
                            const Camera& camera,
                            const Rigid3& map_from_camera,
                            double texel_m,
                            int page_px) {
  PictureChart made = ChartWithoutPicture(mesh, chart);
  const Rigid3 camera_from_map = map_from_camera.Inverse();
  Eigen::Vector2d min(camera.width, camera.height), max(0, 0);
  for (const std::uint32_t vertex : made.vertices) {
    const Eigen::Vector3d position = mesh.vertices[vertex].position_in_map.cast<double>();
    const Eigen::Vector2d pixel = camera.Project(camera_from_map * position).value();
    made.pixels.push_back(pixel);
    min = min.cwiseMin(pixel);
    max = max.cwiseMax(pixel);
  }
  const double room_px = page_px - 2 * kGutter_px - 2;
  const double finest = 1 / std::max(1e-9, texel_m * PixelsPerMetre(mesh, made));
  made.scale = std::min({1.0, finest, room_px / std::max(1.0, (max - min).maxCoeff())});
  made.origin = min.array() - kGutter_px / made.scale;
  if (made.scale == 1) made.origin = made.origin.array().floor();  // pixels become texels
  made.size = made.TexelOf(max).array().ceil().cast<int>() + kGutter_px + 1;
  return made;
}

ColorImage CutFromPicture(const TileMesh& mesh,
                          const PictureChart& chart,
                          const ColorImage& color) {
  const Eigen::Array3d gain = GainOf(mesh, chart, color);
  const int num_parts = static_cast<int>(std::ceil(1 / chart.scale));
  const double part = 1.0 / num_parts;
  ColorImage cut{chart.size.x(), chart.size.y(), 3, {}};
  cut.pixels.reserve(3 * static_cast<std::size_t>(cut.width) *
                     static_cast<std::size_t>(cut.height));
  for (int y = 0; y < cut.height; ++y) {
    for (int x = 0; x < cut.width; ++x) {
      Eigen::Array3d rgb = Eigen::Array3d::Zero();
      for (int i = 0; i < num_parts * num_parts; ++i) {
        const Eigen::Vector2d inside(i % num_parts, static_cast<double>(i / num_parts));
        const Eigen::Vector2d texel =
            Eigen::Vector2d(x, y).array() - 0.5 + part * (inside.array() + 0.5);
        rgb += ColorAt(color, chart.origin + texel / chart.scale);
      }
      rgb = (gain * rgb * part * part + 0.5).min(255.0);
      for (int c = 0; c < 3; ++c) cut.pixels.push_back(static_cast<std::uint8_t>(rgb[c]));
    }
  }
  return cut;
}

}  // namespace nightmap
