// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/refine_corner.h"

#include <array>
#include <cmath>

namespace nightmap {
namespace {

constexpr int kMaxIterations = 20;
constexpr float kConverged_px = 0.005F;
constexpr float kMinEigenRatio = 0.02F;             // of the tensor, about; an edge has 0
constexpr int kSize = 2 * kMaxRefineRadius_px + 2;  // even: a multiple of the lanes of a register

using Row = std::array<float, kSize>;

// Products of the gradients around a pixel.
struct Window {
  int radius = 0;
  std::array<Row, kSize> xx, xy, yy;

  void Load(const GrayView& gray, int x, int y) {
    for (int v = -radius; v <= radius; ++v) {
      const std::uint8_t* row = gray.pixels + (y + v) * gray.row_size + x;
      const auto at = static_cast<std::size_t>(v + radius);
      for (int u = -radius; u <= radius; ++u) {
        const auto gx = static_cast<float>(row[u + 1] - row[u - 1]);
        const auto gy = static_cast<float>(row[u + gray.row_size] - row[u - gray.row_size]);
        const auto k = static_cast<std::size_t>(u + radius);
        xx[at][k] = gx * gx;
        xy[at][k] = gx * gy;
        yy[at][k] = gy * gy;
      }
    }
  }
};

// Weights of the offsets -radius .. radius about `centre`; smooth, and 0 at the window's edge.
Row Weights(float centre, int radius) {
  Row weights{};
  const auto reach = static_cast<float>(radius + 1);
  for (int u = -radius; u <= radius; ++u) {
    const float t = (static_cast<float>(u) - centre) / reach;
    const float root = 1 - t * t;
    weights[static_cast<std::size_t>(u + radius)] = root * root;
  }
  return weights;
}

// Where the gradients aim, from the middle of the window, if weighted about `centre`.
std::optional<Eigen::Vector2f> Aim(const Window& window, const Eigen::Vector2f& centre) {
  const Row across = Weights(centre.x(), window.radius), down = Weights(centre.y(), window.radius);
  const auto count = static_cast<std::size_t>(2 * window.radius + 1);
  Row xx{}, xy{}, yy{}, v_xy{}, v_yy{};  // sums of columns
  for (std::size_t i = 0; i < count; ++i) {
    const float weight = down[i];
    const float v_weight = weight * static_cast<float>(static_cast<int>(i) - window.radius);
    for (std::size_t k = 0; k < count; ++k) {
      xx[k] += weight * window.xx[i][k];
      xy[k] += weight * window.xy[i][k];
      yy[k] += weight * window.yy[i][k];
      v_xy[k] += v_weight * window.xy[i][k];
      v_yy[k] += v_weight * window.yy[i][k];
    }
  }
  float a = 0, b = 0, c = 0, x = 0, y = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const auto u = static_cast<float>(static_cast<int>(k) - window.radius);
    a += across[k] * xx[k];
    b += across[k] * xy[k];
    c += across[k] * yy[k];
    x += across[k] * (u * xx[k] + v_xy[k]);
    y += across[k] * (u * xy[k] + v_yy[k]);
  }
  const float determinant = a * c - b * b;
  const float trace = a + c;
  if (!(determinant > kMinEigenRatio * trace * trace)) return std::nullopt;
  return Eigen::Vector2f((c * x - b * y) / determinant, (a * y - b * x) / determinant);
}

}  // namespace

std::optional<Eigen::Vector2f> RefineCorner(const GrayView& gray,
                                            const Eigen::Vector2f& start,
                                            int radius_px,
                                            double max_move_px) {
  Window window;
  window.radius = radius_px;
  const int margin = radius_px + 1;
  Eigen::Vector2f pixel = start;
  int x = 0, y = 0;
  for (int i = 0; i < kMaxIterations; ++i) {
    const auto next_x = static_cast<int>(std::lround(pixel.x()));
    const auto next_y = static_cast<int>(std::lround(pixel.y()));
    if (i == 0 || next_x != x || next_y != y) {
      x = next_x;
      y = next_y;
      if (x < margin || y < margin || x >= gray.width - margin || y >= gray.height - margin) {
        return std::nullopt;
      }
      window.Load(gray, x, y);
    }
    const Eigen::Vector2f middle(static_cast<float>(x), static_cast<float>(y));
    const auto aim = Aim(window, pixel - middle);
    if (!aim) return std::nullopt;
    const Eigen::Vector2f moved = middle + *aim - pixel;
    pixel += moved;
    if (!(static_cast<double>((pixel - start).norm()) <= max_move_px)) return std::nullopt;
    if (moved.norm() < kConverged_px) return pixel;
  }
  return std::nullopt;
}

}  // namespace nightmap
