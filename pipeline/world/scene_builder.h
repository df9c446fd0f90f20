// SPDX-License-Identifier: Apache-2.0
// Collects boxes, surfaces and the textures they need.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/world/paint.h"
#include "pipeline/world/scene.h"

namespace nightmap {

class SceneBuilder {
 public:
  explicit SceneBuilder(std::uint64_t seed) : seed_(seed) {}

  // One of a few shared variants of a material, at a random offset and tone of its texture. Floors
  // and walls also get a second texture of another period, so that no two places look the same.
  Material Tiled(Paint paint, Random& random);
  // A picture stretched over its surface; equal seeds share the texture.
  Material Picture(Paint paint, std::uint64_t picture_seed);
  Material Plain(const Eigen::Vector3f& tint);
  // One color, without any texture, as if lit evenly: baked light has blotches.
  Material Uniform(const Eigen::Vector3f& tint);

  // Adds a box with one material and, optionally, another one on its front (-y) face.
  void AddBox(const Box& box, const Material& material, const Material* front = nullptr);
  void AddSurface(const Surface& surface) { scene_.surfaces.push_back(surface); }
  void AddSolid(const Box& box) {
    scene_.boxes.push_back(box);
  }  // its surfaces are added separately
  void AddLamp(const Lamp& lamp);
  int AddPiece() { return scene_.num_pieces++; }  // returns the piece_idx of its boxes
  const std::vector<Box>& Boxes() const { return scene_.boxes; }
  const std::vector<Lamp>& Lamps() const { return scene_.lamps; }

  // Paints all textures and returns the scene.
  Scene Finish(int num_threads);

 private:
  using TextureKey = std::tuple<Paint, int, std::uint64_t>;  // paint, size_px, seed
  void DropUnusedTextures();
  int TextureIdx(Paint paint, int size_px, std::uint64_t texture_seed);

  std::uint64_t seed_;
  Scene scene_;
  std::map<TextureKey, int> texture_idx_;
  std::vector<TextureKey> textures_;
};

}  // namespace nightmap
