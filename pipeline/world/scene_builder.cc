// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/scene_builder.h"

#include <algorithm>
#include <optional>

#include "pipeline/base/parallel.h"

namespace nightmap {

namespace {

struct TileStyle {
  int size_px;
  int num_variants;
  double period_m;
  bool is_mottled;  // a second texture is multiplied onto it
  bool is_upright;  // may not be rotated
};

TileStyle StyleOf(Paint paint) {
  switch (paint) {
    case Paint::kWood:
      return {512, 4, 1.1, false, true};
    case Paint::kPlanks:
      return {1024, 2, 1.9, true, true};
    case Paint::kBrick:
      return {1024, 2, 1.9, true, true};
    case Paint::kTerrazzo:
      return {1024, 2, 2.3, true, false};
    case Paint::kCarpet:
      return {1024, 3, 2.1, true, false};
    case Paint::kPlaster:
      return {512, 2, 2.7, false, true};
    case Paint::kWallpaper:
      return {1024, 3, 2.2, true, true};
    case Paint::kCeiling:
      return {512, 1, 2.4, true, true};
    case Paint::kFabric:
      return {512, 4, 0.9, false, true};
    default:
      return {256, 1, 1.0, false, true};
  }
}

constexpr int kPictureSize_px = 256;
constexpr double kMottlePeriod_m = 3.7;

}  // namespace

int SceneBuilder::TextureIdx(Paint paint, int size_px, std::uint64_t texture_seed) {
  const TextureKey key{paint, size_px, texture_seed};
  const auto [found, is_new] = texture_idx_.emplace(key, static_cast<int>(textures_.size()));
  if (is_new) textures_.push_back(key);
  return found->second;
}

Material SceneBuilder::Tiled(Paint paint, Random& random) {
  const TileStyle style = StyleOf(paint);
  const auto variant = random.Index(static_cast<std::size_t>(style.num_variants));
  Material material;
  material.texture_idx = TextureIdx(paint, style.size_px, seed_ * 1000 + variant);
  material.period_m = style.period_m;
  material.offset_m = {random.Uniform(0, 10), random.Uniform(0, 10)};
  if (!style.is_upright) material.rotation_rad = random.Uniform(0, 6.283);
  const double tone = random.Uniform(0.88, 1.08);
  for (int c = 0; c < 3; ++c) {
    material.tint[c] = static_cast<float>(tone * random.Uniform(0.95, 1.05));
  }
  if (style.is_mottled) {
    material.overlay_idx = TextureIdx(Paint::kMottle, 1024, seed_ * 1000 + random.Index(2));
    material.overlay_period_m = kMottlePeriod_m;
  }
  return material;
}

Material SceneBuilder::Picture(Paint paint, std::uint64_t picture_seed) {
  Material material;
  material.texture_idx = TextureIdx(paint, kPictureSize_px, picture_seed);
  material.period_m = 0;
  return material;
}

Material SceneBuilder::Plain(const Eigen::Vector3f& tint) {
  Material material;
  material.texture_idx = TextureIdx(Paint::kPlaster, 512, seed_ * 1000);
  material.period_m = 1.3;
  material.tint = tint;
  return material;
}

Material SceneBuilder::Uniform(const Eigen::Vector3f& tint) {
  constexpr double kWithinATexel_m = 1e7;
  Material material = Plain(tint);
  material.period_m = kWithinATexel_m;
  material.offset_m.setConstant(kWithinATexel_m / 2);
  material.glow = 1;
  return material;
}

void SceneBuilder::AddBox(const Box& box, const Material& material, const Material* front) {
  scene_.boxes.push_back(box);
  const std::array<Surface, 6> faces = BoxFaces(box, material);
  const bool stands_on_floor = box.center.z() - box.half_size.z() <= 1e-9;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i == 5 && stands_on_floor) continue;  // nothing sees the underside
    scene_.surfaces.push_back(faces[i]);
    if (i == 0 && front != nullptr) scene_.surfaces.back().material = *front;
  }
}

void SceneBuilder::AddLamp(const Lamp& lamp) {
  scene_.lamps.push_back(lamp);
  Surface panel;
  panel.origin = lamp.center + Eigen::Vector3d(-lamp.half_size.x(), -lamp.half_size.y(), -0.005);
  panel.edge_u = {2 * lamp.half_size.x(), 0, 0};
  panel.edge_v = {0, 2 * lamp.half_size.y(), 0};
  panel.label = SurfaceLabel::kLamp;
  panel.material = Plain(Eigen::Vector3f::Ones());
  panel.material.glow = 1.1F;
  AddSurface(panel);
}

void SceneBuilder::DropUnusedTextures() {
  std::vector<int> new_idx(textures_.size(), -1);
  std::vector<TextureKey> used;
  const auto keep = [&](int& texture_idx) {
    if (texture_idx < 0) return;
    const auto old_idx = static_cast<std::size_t>(texture_idx);
    if (new_idx[old_idx] < 0) {
      new_idx[old_idx] = static_cast<int>(used.size());
      used.push_back(textures_[old_idx]);
    }
    texture_idx = new_idx[old_idx];
  };
  for (Surface& surface : scene_.surfaces) {
    keep(surface.material.texture_idx);
    keep(surface.material.overlay_idx);
  }
  textures_ = std::move(used);
}

Scene SceneBuilder::Finish(int num_threads) {
  DropUnusedTextures();  // of furniture that did not fit
  std::vector<std::optional<Texture>> painted(textures_.size());
  ParallelFor(textures_.size(), num_threads, [&](std::size_t i) {
    const auto& [paint, size_px, texture_seed] = textures_[i];
    painted[i].emplace(PaintTexture(paint, size_px, texture_seed));
  });
  for (auto& texture : painted) scene_.textures.push_back(std::move(*texture));
  return std::move(scene_);
}

}  // namespace nightmap
