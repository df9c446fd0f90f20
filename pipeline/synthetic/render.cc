// SPDX-License-Identifier: Apache-2.0
#include "pipeline/synthetic/render.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kColorNoiseStream = 401;

// One camera in the world, and the color of the surfaces that its rays hit.
class Shader {
 public:
  Shader(const SyntheticWorld& world, const Camera& camera, const Rigid3& building_from_camera)
      : world_(&world),
        camera_(&camera),
        origin_(building_from_camera.translation),
        rotation_(building_from_camera.rotation.toRotationMatrix()),
        pixel_angle_(static_cast<float>(1 / camera.fx)) {}

  // Ray through a pixel, scaled to depth 1.
  Eigen::Vector3d Direction(double x, double y) const {
    return rotation_ *
           Eigen::Vector3d((x - camera_->cx) / camera_->fx, (y - camera_->cy) / camera_->fy, 1);
  }
  RayHit Cast(const Eigen::Vector3d& direction) const {
    return world_->rays->Cast(origin_, direction);
  }

  // Color of a hit, filtered over `pixel_width` pixels.
  Eigen::Vector3f Color(const RayHit& hit,
                        const Eigen::Vector3d& direction,
                        float pixel_width) const {
    if (hit.surface_idx < 0) return Eigen::Vector3f::Zero();
    const Surface& surface = world_->scene.surfaces[static_cast<std::size_t>(hit.surface_idx)];
    const Eigen::Vector3f albedo = Albedo(surface, hit, direction, pixel_width);
    const float light = surface.material.glow > 0 ? surface.material.glow
                                                  : world_->light.At(hit.surface_idx, hit.a, hit.b);
    return albedo * light;
  }

 private:
  // Anisotropic filter: takes as many samples along the direction of grazing view as that view
  // stretches the pixel (at most 6), each as wide as the pixel is across.
  Eigen::Vector3f Albedo(const Surface& surface,
                         const RayHit& hit,
                         const Eigen::Vector3d& direction,
                         float pixel_width) const {
    const Eigen::Vector3d unit = direction.normalized();
    const Eigen::Vector3d normal = surface.Normal();
    const double cosine = std::max(0.05, std::abs(normal.dot(unit)));
    const double across_m = hit.distance * pixel_angle_ * pixel_width;
    const double along_m = across_m / cosine;
    const int num_taps = std::clamp(static_cast<int>(std::lround(1 / cosine)), 1, 6);
    const double tap_m = std::max(across_m, along_m / num_taps);
    const Eigen::Vector2d lengths(surface.edge_u.norm(), surface.edge_v.norm());
    const Eigen::Vector2d at_m(hit.a * lengths.x(), hit.b * lengths.y());
    const Eigen::Vector3d in_plane = unit - normal * normal.dot(unit);
    Eigen::Vector2d along(in_plane.dot(surface.edge_u) / lengths.x(),
                          in_plane.dot(surface.edge_v) / lengths.y());
    if (along.norm() > 1e-9) along.normalize();
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int tap = 0; tap < num_taps; ++tap) {
      const double shift_m = along_m * ((tap + 0.5) / num_taps - 0.5);
      sum += Texel(surface.material, at_m + shift_m * along, lengths, tap_m);
    }
    return sum.cwiseProduct(surface.material.tint) / static_cast<float>(num_taps);
  }

  Eigen::Vector3f Texel(const Material& material,
                        const Eigen::Vector2d& at_m,
                        const Eigen::Vector2d& lengths_m,
                        double width_m) const {
    const Texture& texture = world_->scene.textures[static_cast<std::size_t>(material.texture_idx)];
    if (material.period_m <= 0) {
      const Eigen::Vector2d uv = at_m.cwiseQuotient(lengths_m).cwiseMax(0.002).cwiseMin(0.998);
      return texture.Sample(uv.cast<float>(), static_cast<float>(width_m / lengths_m.minCoeff()));
    }
    const double c = std::cos(material.rotation_rad);
    const double s = std::sin(material.rotation_rad);
    const Eigen::Vector2d p = at_m + material.offset_m;
    const Eigen::Vector2d turned(c * p.x() - s * p.y(), s * p.x() + c * p.y());
    const Eigen::Vector2f uv = (turned / material.period_m).cast<float>();
    const Eigen::Vector3f color =
        texture.Sample(uv, static_cast<float>(width_m / material.period_m));
    if (material.overlay_idx < 0) return color;
    // Rotated by another angle, so that the two patterns never coincide twice.
    const Eigen::Vector2d other(0.8 * p.x() - 0.6 * p.y(), 0.6 * p.x() + 0.8 * p.y());
    const Eigen::Vector2f overlay_uv = (other / material.overlay_period_m).cast<float>();
    const float overlay_width = static_cast<float>(width_m / material.overlay_period_m);
    const Texture& overlay = world_->scene.textures[static_cast<std::size_t>(material.overlay_idx)];
    return color.cwiseProduct(overlay.Sample(overlay_uv, overlay_width)) / 128.0F;
  }

  const SyntheticWorld* world_;
  const Camera* camera_;
  Eigen::Vector3d origin_;
  Eigen::Matrix3d rotation_;
  float pixel_angle_;
};

template <typename T>
Image<T> MakeImage(const Camera& camera, int num_channels = 1) {
  Image<T> image{camera.width, camera.height, num_channels, {}};
  image.pixels.resize(static_cast<std::size_t>(camera.width) *
                      static_cast<std::size_t>(camera.height) *
                      static_cast<std::size_t>(num_channels));
  return image;
}

bool IsEdge(const Image<std::int32_t>& surface_idx, int x, int y) {
  const std::int32_t center = surface_idx.At(x, y);
  return surface_idx.At(std::max(0, x - 1), y) != center ||
         surface_idx.At(std::min(surface_idx.width - 1, x + 1), y) != center ||
         surface_idx.At(x, std::max(0, y - 1)) != center ||
         surface_idx.At(x, std::min(surface_idx.height - 1, y + 1)) != center;
}

// Mean over a rotated grid of five rays, for pixels that several surfaces share.
Eigen::Vector3f SupersampledColor(const Shader& shader, int x, int y) {
  constexpr std::array<std::array<double, 2>, 5> kOffsets = {
      {{0, 0}, {-0.125, -0.375}, {0.375, -0.125}, {0.125, 0.375}, {-0.375, 0.125}}};
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (const auto& [dx, dy] : kOffsets) {
    const Eigen::Vector3d direction = shader.Direction(x + dx, y + dy);
    sum += shader.Color(shader.Cast(direction), direction, 0.6F);
  }
  return sum / static_cast<float>(kOffsets.size());
}

// Highlights are compressed instead of clipped.
float ToneMap(float level) {
  constexpr float kKnee = 190;
  if (level <= kKnee) return level;
  return kKnee + (255 - kKnee) * (1 - std::exp((kKnee - level) / (255 - kKnee)));
}

// The number of ones among 64 random bits is nearly normal, with mean 32 and deviation 4.
float ColorNoise(Random& random) {
  return (static_cast<float>(std::popcount(random.Next())) - 32.0F) / 4.0F;
}

void StoreColor(const Eigen::Vector3f& color,
                double noise_levels,
                Random& random,
                std::uint8_t* rgb) {
  for (int c = 0; c < 3; ++c) {
    const float noise = static_cast<float>(noise_levels) * ColorNoise(random);
    rgb[c] = static_cast<std::uint8_t>(std::clamp(ToneMap(color[c]) + noise + 0.5F, 0.0F, 255.0F));
  }
}

}  // namespace

RenderedFrame Render(const SyntheticWorld& world,
                     const Camera& camera,
                     const Rigid3& building_from_camera,
                     const DepthSensorOptions& sensor,
                     double color_noise_levels,
                     std::uint64_t noise_seed) {
  if (camera.HasDistortion()) throw UsageError("Render: the synthetic camera has no distortion");
  const Shader shader(world, camera, building_from_camera);
  RenderedFrame frame{MakeImage<std::uint8_t>(camera, 3),
                      {},
                      MakeImage<float>(camera),
                      MakeImage<std::uint8_t>(camera),
                      MakeImage<std::int32_t>(camera)};
  auto incidence_cosine = MakeImage<float>(camera);
  std::vector<RayHit> hits(frame.labels.pixels.size());
  std::size_t i = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x, ++i) {
      const Eigen::Vector3d direction = shader.Direction(x, y);
      hits[i] = shader.Cast(direction);
      frame.surface_idx.pixels[i] = hits[i].surface_idx;
      if (hits[i].surface_idx < 0) continue;
      const Surface& surface = world.scene.surfaces[static_cast<std::size_t>(hits[i].surface_idx)];
      frame.exact_depth.pixels[i] = static_cast<float>(hits[i].distance);
      frame.labels.pixels[i] = static_cast<std::uint8_t>(surface.label);
      incidence_cosine.pixels[i] =
          static_cast<float>(std::abs(surface.Normal().dot(direction.normalized())));
    }
  }
  Random random(noise_seed, kColorNoiseStream);
  i = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x, ++i) {
      const Eigen::Vector3f color = IsEdge(frame.surface_idx, x, y)
                                        ? SupersampledColor(shader, x, y)
                                        : shader.Color(hits[i], shader.Direction(x, y), 1.0F);
      StoreColor(color, color_noise_levels, random, &frame.color.pixels[3 * i]);
    }
  }
  frame.depth = MeasureDepth(
      frame.exact_depth, frame.surface_idx, incidence_cosine, camera, sensor, noise_seed);
  return frame;
}

}  // namespace nightmap
