// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/render.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/world/visible_surfaces.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kColorNoiseStream = 401;

// Values that all points of a surface share.
struct SurfaceShape {
  Eigen::Vector3d normal;
  Eigen::Vector2d lengths_m;  // of its edges
  double cosine = 1;          // of the rotation of its texture
  double sine = 0;
};

SurfaceShape MakeShape(const Surface& surface) {
  return {surface.Normal(),
          {surface.edge_u.norm(), surface.edge_v.norm()},
          std::cos(surface.material.rotation_rad),
          std::sin(surface.material.rotation_rad)};
}

// The textures of a material, filtered over a width.
class Sampler {
 public:
  Sampler(const Scene& scene, const Material& material, const SurfaceShape& shape, double width_m)
      : material_(material),
        shape_(shape),
        texture_(scene.textures[static_cast<std::size_t>(material.texture_idx)]) {
    const double period_m = material.period_m > 0 ? material.period_m : shape.lengths_m.minCoeff();
    filter_ = texture_.FilterOf(static_cast<float>(width_m / period_m));
    if (material.period_m <= 0 || material.overlay_idx < 0) return;
    overlay_ = &scene.textures[static_cast<std::size_t>(material.overlay_idx)];
    overlay_filter_ = overlay_->FilterOf(static_cast<float>(width_m / material.overlay_period_m));
  }

  Eigen::Vector4f At(const Eigen::Vector2d& at_m) const {
    if (material_.period_m <= 0) {
      const Eigen::Vector2d uv =
          at_m.cwiseQuotient(shape_.lengths_m).cwiseMax(0.002).cwiseMin(0.998);
      return Texture::Sample(uv.cast<float>(), filter_);
    }
    const double c = shape_.cosine;
    const double s = shape_.sine;
    const Eigen::Vector2d p = at_m + material_.offset_m;
    const Eigen::Vector2d turned(c * p.x() - s * p.y(), s * p.x() + c * p.y());
    const Eigen::Vector2f uv = (turned / material_.period_m).cast<float>();
    const Eigen::Vector4f color = Texture::Sample(uv, filter_);
    if (overlay_ == nullptr) return color;
    // Rotated by another angle, so that the two patterns never coincide twice.
    const Eigen::Vector2d other(0.8 * p.x() - 0.6 * p.y(), 0.6 * p.x() + 0.8 * p.y());
    const Eigen::Vector2f overlay_uv = (other / material_.overlay_period_m).cast<float>();
    return color.cwiseProduct(Texture::Sample(overlay_uv, overlay_filter_)) / 128.0F;
  }

 private:
  const Material& material_;
  const SurfaceShape& shape_;
  const Texture& texture_;
  Texture::Filter filter_;
  const Texture* overlay_ = nullptr;
  Texture::Filter overlay_filter_;
};

// The view of a surface through a point of the picture.
struct View {
  Eigen::Vector3d direction;  // unit vector in the building
  RayHit hit;                 // its distance is the depth along z
  double facing = 0;          // cosine between the direction and the surface's normal
};

// One camera in the world, and the color of the surfaces that its rays hit.
class Shader {
 public:
  Shader(const SyntheticWorld& world, const Camera& camera, const Rigid3& building_from_camera)
      : world_(&world),
        camera_(&camera),
        origin_(building_from_camera.translation),
        rotation_(building_from_camera.rotation.toRotationMatrix()),
        pixel_angle_(static_cast<float>(1 / camera.fx)),
        visible_(world.scene.surfaces, camera, building_from_camera) {
    shapes_.reserve(world.scene.surfaces.size());
    for (const Surface& surface : world.scene.surfaces) shapes_.push_back(MakeShape(surface));
  }

  // The surface at a point of the picture; -1: none.
  int SurfaceAt(double x, double y) const {
    const std::optional<int> surface_idx = visible_.At(x, y);
    return surface_idx ? *surface_idx : world_->rays->Cast(origin_, Ray(x, y)).surface_idx;
  }

  // The view at a point where SurfaceAt gives `surface_idx`, not -1.
  View Look(double x, double y, int surface_idx) const {
    const Eigen::Vector3d ray = Ray(x, y);
    const Eigen::Vector3d direction = ray.normalized();
    return {direction,
            world_->rays->HitOn(surface_idx, origin_, ray),
            shapes_[static_cast<std::size_t>(surface_idx)].normal.dot(direction)};
  }

  // Color of a view, filtered over `pixel_width` pixels. The fourth value means nothing.
  Eigen::Vector4f Color(const View& view, float pixel_width) const {
    const RayHit& hit = view.hit;
    const Surface& surface = world_->scene.surfaces[static_cast<std::size_t>(hit.surface_idx)];
    const Eigen::Vector4f albedo = Albedo(surface, view, pixel_width);
    const float light = surface.material.glow > 0 ? surface.material.glow
                                                  : world_->light.At(hit.surface_idx, hit.a, hit.b);
    return albedo * light;
  }

 private:
  // Ray through a point of the picture, scaled to depth 1.
  Eigen::Vector3d Ray(double x, double y) const {
    return rotation_ *
           Eigen::Vector3d((x - camera_->cx) / camera_->fx, (y - camera_->cy) / camera_->fy, 1);
  }

  // Direction in which the view grazes the surface, along its edges; a unit vector.
  static Eigen::Vector2d AlongSurface(const Surface& surface,
                                      const SurfaceShape& shape,
                                      const View& view) {
    const Eigen::Vector3d in_plane = view.direction - shape.normal * view.facing;
    return Eigen::Vector2d(in_plane.dot(surface.edge_u) / shape.lengths_m.x(),
                           in_plane.dot(surface.edge_v) / shape.lengths_m.y())
        .normalized();
  }

  // Anisotropic filter: takes as many samples along the direction of grazing view as that view
  // stretches the pixel (at most 6), each as wide as the pixel is across.
  Eigen::Vector4f Albedo(const Surface& surface, const View& view, float pixel_width) const {
    const SurfaceShape& shape = shapes_[static_cast<std::size_t>(view.hit.surface_idx)];
    const double cosine = std::max(0.05, std::abs(view.facing));
    const double across_m = view.hit.distance * pixel_angle_ * pixel_width;
    const double along_m = across_m / cosine;
    const int num_taps = std::min(static_cast<int>(std::floor(1 / cosine + 0.5)), 6);
    const double tap_m = std::max(across_m, along_m / num_taps);
    const Eigen::Vector2d& lengths_m = shape.lengths_m;
    const Eigen::Vector2d at_m(view.hit.a * lengths_m.x(), view.hit.b * lengths_m.y());
    const Eigen::Vector2d along =
        num_taps > 1 ? AlongSurface(surface, shape, view) : Eigen::Vector2d::Zero();
    const Sampler sampler(world_->scene, surface.material, shape, tap_m);
    Eigen::Vector4f sum = Eigen::Vector4f::Zero();
    for (int tap = 0; tap < num_taps; ++tap) {
      const double shift_m = along_m * ((tap + 0.5) / num_taps - 0.5);
      sum += sampler.At(at_m + shift_m * along);
    }
    const Eigen::Vector3f& tint = surface.material.tint;
    return sum.cwiseProduct(Eigen::Vector4f(tint.x(), tint.y(), tint.z(), 0)) /
           static_cast<float>(num_taps);
  }

  const SyntheticWorld* world_;
  const Camera* camera_;
  Eigen::Vector3d origin_;
  Eigen::Matrix3d rotation_;
  float pixel_angle_;
  VisibleSurfaces visible_;
  std::vector<SurfaceShape> shapes_;
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
Eigen::Vector4f SupersampledColor(const Shader& shader, int x, int y) {
  constexpr std::array<std::array<double, 2>, 5> kOffsets = {
      {{0, 0}, {-0.125, -0.375}, {0.375, -0.125}, {0.125, 0.375}, {-0.375, 0.125}}};
  Eigen::Vector4f sum = Eigen::Vector4f::Zero();
  for (const auto& [dx, dy] : kOffsets) {
    const int surface_idx = shader.SurfaceAt(x + dx, y + dy);
    if (surface_idx >= 0) sum += shader.Color(shader.Look(x + dx, y + dy, surface_idx), 0.6F);
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

void StoreColor(const Eigen::Vector4f& color,
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
  std::size_t i = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x, ++i) {
      frame.surface_idx.pixels[i] = shader.SurfaceAt(x, y);
    }
  }
  Random random(noise_seed, kColorNoiseStream);
  i = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x, ++i) {
      const int surface_idx = frame.surface_idx.pixels[i];
      Eigen::Vector4f color = Eigen::Vector4f::Zero();
      if (surface_idx >= 0) {
        const View view = shader.Look(x, y, surface_idx);
        const Surface& surface = world.scene.surfaces[static_cast<std::size_t>(surface_idx)];
        frame.exact_depth.pixels[i] = static_cast<float>(view.hit.distance);
        frame.labels.pixels[i] = static_cast<std::uint8_t>(surface.label);
        incidence_cosine.pixels[i] = static_cast<float>(std::abs(view.facing));
        color = shader.Color(view, 1.0F);
      }
      if (IsEdge(frame.surface_idx, x, y)) color = SupersampledColor(shader, x, y);
      StoreColor(color, color_noise_levels, random, &frame.color.pixels[3 * i]);
    }
  }
  frame.depth = MeasureDepth(
      frame.exact_depth, frame.surface_idx, incidence_cosine, camera, sensor, noise_seed);
  return frame;
}

}  // namespace nightmap
